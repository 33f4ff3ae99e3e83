"""Normals of vertices from the faces around them."""

from collections.abc import Sequence

import numpy as np

from service.formats.points.reading import Array
from service.jobs.errors import MalformedInputError

LONGEST_NUMBER = 12  # digits


def triangles(polygons: Array | Sequence[Array] | Sequence[Sequence[int]]) -> Array:
    """Return the triangles (M, 3) of polygons, which are fans around their first corners.

    >>> triangles([[0, 1, 2], [3, 4, 5, 6], [7, 8]]).tolist()
    [[0, 1, 2], [3, 4, 5], [3, 5, 6]]
    """
    if isinstance(polygons, np.ndarray) and polygons.shape[1] == 3:
        return _positions(polygons)
    fans = [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)]
    return _positions(np.array(fans).reshape(-1, 3))


def position(text: str) -> int:
    """Return the number of a vertex or a normal in a face.

    Raises
    ------
    ValueError
        If it is no whole number, or larger than any file has.

    """
    if len(text) > LONGEST_NUMBER:
        raise ValueError("the number of a vertex is too large")
    return int(text)


def _positions(numbers: Array) -> Array:
    """Return whole numbers (M, 3) as integers; text files may give them as floats."""
    if not (np.abs(numbers) < 10.0**LONGEST_NUMBER).all() or (numbers != np.round(numbers)).any():
        raise MalformedInputError("a face has a vertex whose number is no whole number", ("points",))
    return numbers.astype(np.int64)


def vertex_normals(points: Array, faces: Array) -> Array | None:
    """Return the unit normals (N, 3) of points (N, 3), or None if a point has none.

    Parameters
    ----------
    points, faces
        Vertices (N, 3), and triangles (M, 3) as positions of vertices. Seen from outside, the corners of each go round
        counter-clockwise: it is taken to be so.

    Raises
    ------
    MalformedInputError
        If a face has a vertex that is not there.

    """
    if not len(faces):
        return None
    wrong = np.flatnonzero((faces < 0) | (faces >= len(points)))
    if len(wrong):
        raise MalformedInputError(
            f"a face has vertex {faces.flat[wrong[0]]}, but there are {len(points)}, from 0", ("points",)
        )
    if not np.isfinite(points).all():
        return None
    from trimesh import Trimesh  # noqa: PLC0415 - loads for half a second; only who reads a mesh should wait for it

    largest = float(np.abs(points).max()) or 1.0  # divided out: products of coordinates may overflow, and normals stay
    mesh = Trimesh(points / largest, faces, process=False, validate=False)
    normals = np.asarray(mesh.vertex_normals)
    return normals if (np.linalg.norm(normals, axis=1) > 0.5).all() else None
