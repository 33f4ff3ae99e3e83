"""Vertices of meshes in STL and GLB, which trimesh reads. No other file that they name is opened."""

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any, cast

import numpy as np
import orjson
import trimesh

from service.formats.points import faces
from service.formats.points.reading import Array, RawPoints, ReadOptions, check_count, check_no_columns, shortened
from service.jobs.errors import MalformedInputError

ENTRIES_PER_POINT = 24  # of a GLB's accessors for each point: indices of faces, normals, colours, texture coordinates


def read_stl(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the distinct corners of an STL file's triangles, with normals from the triangles.

    Raises
    ------
    MalformedInputError
        If the bytes are not an STL file.
    TooLargeError
        If there are more than `max_points` corners.

    """
    check_no_columns(options, "STL")
    corners = np.asarray(_loaded(content, "stl").vertices, dtype=np.float64)
    points, positions = np.unique(corners, axis=0, return_inverse=True)
    check_count(len(points), options.max_points)
    return RawPoints(points, faces.vertex_normals(points, positions.reshape(-1, 3)))


def read_glb(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the vertices of a GLB file, in the scene's coordinates, with the normals that it gives or its faces have.

    Raises
    ------
    MalformedInputError
        If the bytes are not a GLB file.
    TooLargeError
        If there are more than `max_points` vertices.

    """
    check_no_columns(options, "GLB")
    _check_glb(content, options.max_points)
    shape = _loaded(content, "glb")
    points = np.asarray(shape.vertices, dtype=np.float64)
    if not isinstance(shape, trimesh.Trimesh):
        return RawPoints(points)
    with _as_malformed("glb"):
        normals: Array = np.asarray(shape.vertex_normals)
    return RawPoints(points, normals if (np.linalg.norm(normals, axis=1) > 0.5).all() else None)


def _loaded(content: bytes, kind: str) -> Any:  # noqa: ANN401 - of trimesh, whose types say little
    """Return the one shape of a file of this kind; without a name and a folder nothing else can be opened."""
    with _as_malformed(kind):
        file = BytesIO(content)
        shape = cast("Any", trimesh.load(file, file_type=kind, process=False, skip_materials=True, resolver=None))
        if isinstance(shape, trimesh.Scene):
            shape = shape.to_geometry()
    if not len(getattr(shape, "vertices", ())):
        raise MalformedInputError(f"there are no vertices in this {kind.upper()} file", ("points",))
    return shape


@contextmanager
def _as_malformed(kind: str) -> Iterator[None]:
    """Raise MalformedInputError for whatever trimesh meets in a file of this kind; it has no errors of its own."""
    try:
        with np.errstate(all="ignore"):
            yield
    except MemoryError:
        raise
    except Exception as error:
        raise MalformedInputError(f"not {kind.upper()}: {shortened(str(error), 200)}", ("points",)) from error


def _check_glb(content: bytes, max_points: int) -> None:
    """Refuse a GLB file whose vertices, as often as its nodes use them, are too many, or are not in the file."""
    try:
        size = int.from_bytes(content[12:16], "little")
        tree = orjson.loads(content[20 : 20 + size])
        accessors = [_count(accessor) for accessor in tree.get("accessors", [])]
        used = [_vertices_of(mesh, accessors) for mesh in tree.get("meshes", [])]
        instances = [node["mesh"] for node in tree.get("nodes", []) if "mesh" in node]
        count = sum(used[mesh] for mesh in instances)
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        raise MalformedInputError(f"not GLB: {shortened(str(error), 200)}", ("points",)) from error
    check_count(count, max_points)
    check_count(sum(accessors), ENTRIES_PER_POINT * max_points, "entries of accessors")


def _count(accessor: Any) -> int:  # noqa: ANN401 - JSON
    """Return the entries of an accessor, which must have data: of none, trimesh makes as many zeros as it says."""
    count = accessor["count"]
    if type(count) is not int or count < 0 or "bufferView" not in accessor:
        raise ValueError("an accessor has no data")
    return count


def _vertices_of(mesh: Any, counts: list[int]) -> int:  # noqa: ANN401 - JSON
    """Return the number of vertices of a mesh, given the counts of the accessors."""
    return sum(counts[part["attributes"]["POSITION"]] for part in mesh["primitives"])
