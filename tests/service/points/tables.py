"""Text tables of points, and what is read of them."""

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


def read(
    text: str | bytes, columns: str | None = None, missing: Missing = "refuse", most: int = 1000
) -> ReceivedPoints:
    content = text if isinstance(text, bytes) else text.encode()
    return decode.read(content, "csv", most, columns=columns, missing=missing)


def refused(text: str | bytes, columns: str | None = None, missing: Missing = "refuse") -> str:
    with pytest.raises(InvalidInputError) as caught:
        read(text, columns, missing)
    return str(caught.value)


def lines(table: Array, delimiter: str = ",", decimal: str = ".") -> list[str]:
    return [delimiter.join(repr(float(value)).replace(".", decimal) for value in row) for row in table]


def text(rows: list[str], end: str = "\n") -> str:
    return "".join(row + end for row in rows)


def gives(found: ReceivedPoints, points: Array, normals: Array | None = None) -> bool:
    x, n = decode.split(found.content, found.dimension)
    if (n is None) != (normals is None):
        return False
    return np.array_equal(x, points) and (n is None or normals is None or np.allclose(n, normals, atol=1e-15))
