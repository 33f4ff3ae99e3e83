"""Points of ellipses, spheres and tori with their true normals."""

import numpy as np

from ipcore._typing import FloatArray


def ellipse(n: int, a: float = 1.0, b: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return points at even parameters and their outward normals."""
    turn = 2 * np.pi * np.arange(n) / n
    c, s = np.cos(turn), np.sin(turn)
    normals = np.column_stack([b * c, a * s])
    return np.column_stack([a * c, b * s]), normals / np.linalg.norm(normals, axis=1, keepdims=True)


def sphere(n: int) -> FloatArray:
    """Return the golden spiral on the unit sphere: points, and normals too."""
    height = 1 - (2 * np.arange(n) + 1) / n
    turn, radius = np.pi * (1 + 5**0.5) * np.arange(n), np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def torus(n: int, minor: float = 0.4) -> tuple[FloatArray, FloatArray]:
    u, v = np.random.default_rng(0).uniform(0, 2 * np.pi, (2, n))
    normals = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    return np.column_stack([np.cos(u), np.sin(u), 0 * u]) + minor * normals, normals


def mixed(*arrays: FloatArray) -> list[FloatArray]:
    """Return arrays with their rows in one random order."""
    order = np.random.default_rng(3).permutation(len(arrays[0]))
    return [array[order] for array in arrays]


def cosine(found: FloatArray, true: FloatArray) -> FloatArray:
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, rtol=1e-12)
    return np.asarray((found * true).sum(axis=1))
