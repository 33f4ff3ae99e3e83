"""Point sets for the bodies of requests."""

from io import BytesIO
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ipcore import shapes

Array = NDArray[Any]


def npy(table: ArrayLike, order: Literal["C", "F"] = "C") -> bytes:
    """Return an array as an npy file."""
    file = BytesIO()
    np.save(file, np.asarray(table, order=order))
    return file.getvalue()


def ellipse(count: int = 60) -> Array:
    """Return points along an ellipse, (N, 2)."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.stack([2.5 + 2.5 * np.cos(angle), 1.0 + 1.8 * np.sin(angle)], axis=1)


def sphere(count: int = 200) -> Array:
    """Return points and normals of a unit sphere, (N, 6)."""
    return np.hstack(shapes.sphere().sample(count))


def torus(count: int = 400) -> Array:
    """Return points and normals of a torus, (N, 6)."""
    return np.hstack(shapes.torus().sample(count))


# With t1=0 no degree is close enough, and a fit of many points goes on to max_degree:
# 7 takes a second or two, 16 some 30.
LONG = npy(torus(20_000))
SOME_SECONDS = "t1=0&max_degree=7"
HALF_A_MINUTE = "t1=0&max_degree=16"


def huge_torus(count: int) -> Array:
    """Return points and normals of a torus, (N, 6), not evenly spread but quickly made."""
    u, v = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (2, count))
    n = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], axis=1)
    ring = np.stack([np.cos(u), np.sin(u), np.zeros(count)], axis=1)
    return np.hstack([ring + 0.4 * n, n])
