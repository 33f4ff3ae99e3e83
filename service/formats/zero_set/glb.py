"""GLB: binary glTF 2.0."""

import json
from typing import Any

import numpy as np

import ipcore
from service.formats.zero_set import single_precision
from service.formats.zero_set.chunks import blocks, joined, uint32

NAME = "zero set"
GLB_NOTES = {
    "unit": "that of the data, not the metre",
    "axes": "those of the data; none of them is up",
    "precision": "float32 about the middle of the surface, where the node's matrix places it",
}
# Numbers that glTF 2.0 defines: types of chunks, targets of buffers, types of components, and the mode "triangles".
JSON_CHUNK, BIN_CHUNK = 0x4E4F534A, 0x004E4942
ARRAY, ELEMENT_ARRAY = 34962, 34963
FLOAT, UNSIGNED_INT = 5126, 5125
TRIANGLES = 4


def write(surface: ipcore.ZeroSet) -> bytes:
    """Return binary glTF 2.0: one node with one mesh, without material; no node if there is no face.

    A header, a chunk of JSON, and one of positions, normals and indices, each of a size that is a multiple of 4.

    Raises
    ------
    InvalidInputError
        If single precision cannot hold it.

    """
    middle = _middle(surface.vertices)
    single_precision.check(surface, "glb", about=middle)
    text = json.dumps(_tree(surface, middle), separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % 4)
    size = sum(_sizes(surface))
    whole = 12 + 8 + len(text) + (8 + size if size else 0)
    return joined(
        [b"glTF", uint32(2, whole, len(text), JSON_CHUNK), text, uint32(size, BIN_CHUNK) if size else b""],
        ((rows - middle).astype("<f4").tobytes() for rows in blocks(surface.vertices)),
        (rows.astype("<f4").tobytes() for rows in blocks(surface.normals)),
        (rows.astype("<u4").tobytes() for rows in blocks(surface.cells)),
    )


def _middle(vertices: ipcore.FloatArray) -> ipcore.FloatArray:
    """Return the middle (3,) of the vertices' box; the origin if there are none."""
    return (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0 if len(vertices) else np.zeros(3)


def _sizes(surface: ipcore.ZeroSet) -> tuple[int, int, int]:
    """Return the bytes that positions, normals and indices take in a GLB file: 4 for each number."""
    return 12 * len(surface.vertices), 12 * len(surface.normals), 12 * len(surface.cells)


def _tree(surface: ipcore.ZeroSet, middle: ipcore.FloatArray) -> dict[str, Any]:
    """Return the JSON chunk of the file; `middle` (3,) is the translation of its node."""
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
