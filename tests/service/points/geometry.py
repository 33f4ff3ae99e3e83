"""A ball as vertices and faces, and what is read of files with them."""

import numpy as np
import pytest
import trimesh
from hypothesis import settings

from service.formats.points import decode
from service.jobs.errors import InvalidInputError
from service.jobs.fit import ReceivedPoints
from tests.service.bodies import Array, sphere

BALL = sphere(30)
MESH = trimesh.creation.icosphere(subdivisions=1)
VERTICES, FACES = np.asarray(MESH.vertices), np.asarray(MESH.faces)
QUICK = settings(deadline=None, max_examples=40)


def read(content: bytes | str, kind: str, most: int = 1000) -> ReceivedPoints:
    return decode.read(content.encode() if isinstance(content, str) else content, kind, most)


def refused(content: bytes | str, kind: str) -> str:
    with pytest.raises(InvalidInputError) as caught:
        read(content, kind)
    return str(caught.value)


def gives(found: ReceivedPoints, points: Array, normals: Array | None = None, within: float = 1e-9) -> bool:
    x, n = decode.split(found.content, found.dimension)
    if (n is None) != (normals is None) or x.shape != points.shape:
        return False
    return np.allclose(x, points, atol=within) and (
        n is None or normals is None or np.allclose(n, normals, atol=within)
    )


def rows(word: str, table: Array, end: str = "\n") -> str:
    return "".join(" ".join([word, *map(repr, map(float, row))]).strip() + end for row in table)
