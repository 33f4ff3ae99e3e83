"""Arrays and archives of points, and what is read of them."""

from collections.abc import Callable
from io import BytesIO

import numpy as np
import pytest
from hypothesis import settings

from service.formats.points import decode
from service.jobs.errors import InvalidInputError
from service.jobs.fit import ReceivedPoints
from service.jobs.media_types import Missing
from tests.service.bodies import Array, ellipse, sphere

BALL = sphere(30)
OUTLINE = ellipse(20)
NAMES = ("x", "y", "z", "nx", "ny", "nz")
QUICK = settings(deadline=None, max_examples=60)


def read(content: bytes, kind: str = "npy", columns: str | None = None, missing: Missing = "refuse") -> ReceivedPoints:
    return decode.read(content, kind, 1000, columns=columns, missing=missing)


def refused(content: bytes, kind: str = "npy", columns: str | None = None) -> InvalidInputError:
    with pytest.raises(InvalidInputError) as caught:
        read(content, kind, columns)
    return caught.value


def npz(**arrays: Array) -> bytes:
    return saved(arrays, np.savez)


def saved(arrays: dict[str, Array], save: Callable[..., None]) -> bytes:
    file = BytesIO()
    save(file, **arrays)
    return file.getvalue()


def records(table: Array, names: list[str], kinds: list[str], more: list[tuple[str, str]]) -> Array:
    made = np.zeros(len(table), dtype=[*zip(names, kinds, strict=True), *more])
    for i, name in enumerate(names):
        made[name] = table[:, i]
    return made


def gives(found: ReceivedPoints, points: Array, normals: Array | None = None, within: float = 1e-15) -> bool:
    x, n = decode.split(found.content, found.dimension)
    if (n is None) != (normals is None):
        return False
    return np.allclose(x, points, atol=within) and (
        n is None or normals is None or np.allclose(n, normals, atol=within)
    )
