"""Surfaces as GLB, PLY, STL and OBJ, each with faces that are counter-clockwise seen from outside.

| format | coordinates | normals | loses |
| --- | --- | --- | --- |
| GLB | float32 about the middle, which stands in the node's matrix | of vertices | digits below 1e-7 of the size |
| PLY | float64 | of vertices | nothing |
| STL | float32 | of faces | digits below 1e-7 of the distance from the origin, and which faces share a vertex |
| OBJ | decimal, 17 digits | of vertices | nothing |

The unit of length and the axes are those of the data in all of them, though glTF would have metres and y up.
All are written some rows at a time, so that a file of any size takes hardly more memory than itself.
"""

import json
from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipcore._typing import FloatArray, IntArray
from ipcore.zero_set.mesh import cell_vectors
from ipcore.zero_set.zero_set import ZeroSet

Table = NDArray[Any]

ROWS = 1 << 15  # at once: 2 MB of the longest, those of STL
NAME = "zero set"
GLB_NOTES = {
    "unit": "that of the data, not the metre",
    "axes": "those of the data; none of them is up",
    "precision": "float32 about the middle of the surface, where the node's matrix places it",
}
# The numbers of glTF 2.0: types of chunks, kinds of buffers, types of components, and triangles as what is drawn.
JSON, BIN = 0x4E4F534A, 0x004E4942
ARRAY, ELEMENT_ARRAY = 34962, 34963
FLOAT, UNSIGNED_INT = 5126, 5125
TRIANGLES = 4


def glb(surface: ZeroSet) -> bytes:
    """Return binary glTF 2.0: one node with one mesh, without material; no node if there is no face.

    A header, a chunk of JSON, and one of positions, normals and indices, each of a size that is a multiple of 4.
    """
    middle = _middle(surface.vertices)
    text = json.dumps(_tree(surface, middle), separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % 4)
    size = sum(_sizes(surface))
    whole = 12 + 8 + len(text) + (8 + size if size else 0)
    return _written(
        [b"glTF", _integers(2, whole, len(text), JSON), text, _integers(size, BIN) if size else b""],
        ((rows - middle).astype("<f4").tobytes() for rows in _blocks(surface.vertices)),
        (rows.astype("<f4").tobytes() for rows in _blocks(surface.normals)),
        (rows.astype("<u4").tobytes() for rows in _blocks(surface.cells)),
    )


def ply(surface: ZeroSet) -> bytes:
    """Return binary little-endian PLY 1.0, vertices with normals."""
    header = [
        "ply",
        "format binary_little_endian 1.0",
        "comment unit and axes are those of the data",
        f"element vertex {len(surface.vertices)}",
        *(f"property double {name}" for name in ("x", "y", "z", "nx", "ny", "nz")),
        f"element face {len(surface.cells)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    vertices = zip(_blocks(surface.vertices), _blocks(surface.normals), strict=True)
    return _written(
        ["\n".join(header).encode("ascii")],
        (np.hstack(both).astype("<f8", copy=False).tobytes() for both in vertices),
        (_ply_faces(cells).tobytes() for cells in _blocks(surface.cells)),
    )


def stl(surface: ZeroSet) -> bytes:
    """Return binary STL: 80 bytes of header, the number of faces, then normal, corners and two zero bytes of each."""
    header = b"binary STL; unit and axes are those of the data".ljust(80)
    return _written(
        [header, _integers(len(surface.cells))],
        (_stl_faces(surface.vertices, cells).tobytes() for cells in _blocks(surface.cells)),
    )


def obj(surface: ZeroSet) -> bytes:
    """Return Wavefront OBJ text: v, vn and f lines, counted from 1."""
    return _written(
        [b"# unit and axes are those of the data\n"],
        (_lines("v %.17g %.17g %.17g\n", rows) for rows in _blocks(surface.vertices)),
        (_lines("vn %.17g %.17g %.17g\n", rows) for rows in _blocks(surface.normals)),
        (_lines("f %d//%d %d//%d %d//%d\n", np.repeat(rows + 1, 2, axis=1)) for rows in _blocks(surface.cells)),
    )


def _written(*parts: Iterable[bytes]) -> bytes:
    """Return all parts in a row. What was written into memory is handed out without a copy."""
    out = BytesIO()
    for part in chain(*parts):
        out.write(part)
    return out.getvalue()


def _blocks(table: Table) -> Iterator[Table]:
    return (table[start : start + ROWS] for start in range(0, len(table), ROWS))


def _integers(*numbers: int) -> bytes:
    return b"".join(number.to_bytes(4, "little") for number in numbers)


def _middle(vertices: FloatArray) -> FloatArray:
    """Return the middle (3,) of the vertices' box; the origin if there are none."""
    return (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0 if len(vertices) else np.zeros(3)


def _sizes(surface: ZeroSet) -> tuple[int, int, int]:
    """Return the bytes that positions, normals and indices take in a GLB file: 4 for each number."""
    return 12 * len(surface.vertices), 12 * len(surface.normals), 12 * len(surface.cells)


def _tree(surface: ZeroSet, middle: FloatArray) -> dict[str, Any]:
    """Return the JSON of a GLB file."""
    tree: dict[str, Any] = {"asset": {"version": "2.0", "generator": "ipfit", "extras": GLB_NOTES}, "scene": 0}
    if not len(surface.cells):  # no accessor may be empty
        return tree | {"scenes": [{}]}
    low, high = (
        (x - middle).astype("f4").tolist() for x in (surface.vertices.min(axis=0), surface.vertices.max(axis=0))
    )
    attribute = {"componentType": FLOAT, "count": len(surface.vertices), "type": "VEC3"}
    index = {"componentType": UNSIGNED_INT, "count": surface.cells.size, "type": "SCALAR"}
    sizes, targets = _sizes(surface), (ARRAY, ARRAY, ELEMENT_ARRAY)
    starts = (0, sizes[0], sizes[0] + sizes[1])
    views = [
        {"buffer": 0, "byteOffset": start, "byteLength": size, "target": target}
        for start, size, target in zip(starts, sizes, targets, strict=True)
    ]
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "mode": TRIANGLES}
    return tree | {
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": NAME, "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *middle.tolist(), 1]}],
        "meshes": [{"name": NAME, "primitives": [primitive]}],
        "accessors": [
            attribute | {"bufferView": 0, "min": low, "max": high},
            attribute | {"bufferView": 1},
            index | {"bufferView": 2},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": sum(sizes)}],
    }


def _ply_faces(cells: IntArray) -> Table:
    faces = np.empty(len(cells), dtype=[("corners", "u1"), ("vertex_indices", "<i4", 3)])
    faces["corners"], faces["vertex_indices"] = 3, cells
    return faces


def _stl_faces(vertices: FloatArray, cells: IntArray) -> Table:
    faces = np.zeros(len(cells), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    normals = cell_vectors(vertices, cells)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    faces["normal"] = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    faces["corners"] = vertices[cells]
    return faces


def _lines(pattern: str, table: Table) -> bytes:
    """Return one line per row (…, k). One `%` for many rows takes a third of the time of one for each."""
    return (pattern * len(table) % tuple(table.ravel().tolist())).encode("ascii")
