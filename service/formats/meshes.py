"""Surfaces as GLB, PLY, STL and OBJ, each with faces that are counter-clockwise seen from outside.

| format | coordinates | normals | loses |
| --- | --- | --- | --- |
| GLB | float32 about the middle, which stands in the node's matrix | of vertices | digits below 1e-7 of the size |
| PLY | float64 | of vertices | nothing |
| STL | float32 | of faces | digits below 1e-7 of the distance from the origin, and which faces share a vertex |
| OBJ | decimal, 17 digits | of vertices | nothing |

The unit of length and the axes are those of the data in all of them, though glTF would have metres and y up.
"""

from typing import Any

import numpy as np
import trimesh
from trimesh.exchange.gltf import export_glb

from ipcore._typing import FloatArray
from ipcore.mesh import cell_vectors
from ipcore.zero_set import ZeroSet

GLB_NOTES = {
    "unit": "that of the data, not the metre",
    "axes": "those of the data; none of them is up",
    "precision": "float32 about the middle of the surface, where the node's matrix places it",
}
NAME = "zero set"


def glb(surface: ZeroSet) -> bytes:
    """Return binary glTF 2.0: one node with one mesh, without material."""
    middle = _middle(surface.vertices)
    normals = surface.normals if len(surface.normals) else None  # trimesh takes no empty array of normals
    mesh = trimesh.Trimesh(surface.vertices - middle, surface.cells, vertex_normals=normals, process=False)
    placed = np.eye(4)
    placed[:3, 3] = middle
    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name=NAME, geom_name=NAME, transform=placed)
    return bytes(export_glb(scene, include_normals=True, tree_postprocessor=_annotate))  # type: ignore[no-untyped-call]


def ply(surface: ZeroSet) -> bytes:
    """Return binary little-endian PLY 1.0, vertices with normals."""
    faces = np.empty(len(surface.cells), dtype=[("corners", "u1"), ("vertex_indices", "<i4", 3)])
    faces["corners"], faces["vertex_indices"] = 3, surface.cells
    header = [
        "ply",
        "format binary_little_endian 1.0",
        "comment unit and axes are those of the data",
        f"element vertex {len(surface.vertices)}",
        *(f"property double {name}" for name in ("x", "y", "z", "nx", "ny", "nz")),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    vertices = np.hstack([surface.vertices, surface.normals]).astype("<f8")
    return "\n".join(header).encode("ascii") + vertices.tobytes() + faces.tobytes()


def stl(surface: ZeroSet) -> bytes:
    """Return binary STL: 80 bytes of header, the number of faces, then normal, corners and two zero bytes of each."""
    faces = np.zeros(
        len(surface.cells), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")]
    )
    normals = cell_vectors(surface.vertices, surface.cells)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    faces["normal"] = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    faces["corners"] = surface.vertices[surface.cells]
    header = b"binary STL; unit and axes are those of the data".ljust(80)
    return header + len(faces).to_bytes(4, "little") + faces.tobytes()


def obj(surface: ZeroSet) -> bytes:
    """Return Wavefront OBJ text: v, vn and f lines, counted from 1."""
    lines = ["# unit and axes are those of the data\n"]
    lines += _rows("v %.17g %.17g %.17g\n", surface.vertices)
    lines += _rows("vn %.17g %.17g %.17g\n", surface.normals)
    lines += _rows("f %d//%d %d//%d %d//%d\n", np.repeat(surface.cells + 1, 2, axis=1))
    return "".join(lines).encode("ascii")


def _middle(vertices: FloatArray) -> FloatArray:
    """Return the middle (3,) of the vertices' box; the origin if there are none."""
    return (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0 if len(vertices) else np.zeros(3)


def _annotate(tree: dict[str, Any]) -> None:
    tree["asset"]["extras"] = GLB_NOTES


def _rows(pattern: str, table: np.ndarray) -> list[str]:
    """Return one line per row (…, k). One `%` for all rows takes a third of the time of one for each."""
    return [pattern * len(table) % tuple(table.ravel().tolist())]
