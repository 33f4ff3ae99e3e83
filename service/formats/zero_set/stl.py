"""STL, binary."""

import numpy as np

import ipcore
from service.formats.zero_set import single_precision
from service.formats.zero_set.chunks import Table, blocks, joined, uint32


def write(surface: ipcore.ZeroSet) -> bytes:
    """Return binary STL: 80 bytes of header, the number of faces, then normal, corners and two zero bytes of each.

    Raises
    ------
    InvalidInputError
        If single precision cannot hold it.

    """
    single_precision.check(surface, "stl")
    header = b"binary STL; unit and axes are those of the data".ljust(80)
    records = zip(blocks(surface.cells), blocks(surface.cell_normals()), strict=True)
    return joined(
        [header, uint32(len(surface.cells))],
        (_faces(surface.vertices, *both).tobytes() for both in records),
    )


def _faces(vertices: ipcore.FloatArray, cells: ipcore.IntArray, normals: ipcore.FloatArray) -> Table:
    """Return the records (F,) of triangles (F, 3) of vertices (V, 3) with normals (F, 3) of any length."""
    faces = np.zeros(len(cells), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    faces["normal"] = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    faces["corners"] = vertices[cells]
    return faces
