"""PLY 1.0, binary."""

import numpy as np

import ipcore
from service.formats.zero_set.chunks import Table, blocks, joined


def write(surface: ipcore.ZeroSet) -> bytes:
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
    vertices = zip(blocks(surface.vertices), blocks(surface.normals), strict=True)
    return joined(
        ["\n".join(header).encode("ascii")],
        (np.hstack(both).astype("<f8", copy=False).tobytes() for both in vertices),
        (_faces(cells).tobytes() for cells in blocks(surface.cells)),
    )


def _faces(cells: ipcore.IntArray) -> Table:
    """Return the records (F,) of triangles (F, 3): the number of corners and the vertices there."""
    faces = np.empty(len(cells), dtype=[("corners", "u1"), ("vertex_indices", "<i4", 3)])
    faces["corners"], faces["vertex_indices"] = 3, cells
    return faces
