"""Cells of f = 0 on a grid: the pieces of its blocks joined."""

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.grid import Blocks, Grid, Piece
from ipcore.marching import march
from ipcore.mesh import Mesh


def extract(values: FloatArray, axes: list[FloatArray]) -> Mesh:
    """Return the cells of f = 0, closed along the walls, given f on the grid of evenly spaced raw grid lines `axes`.

    >>> line = np.linspace(-2.0, 2.0, 5)
    >>> mesh = extract(np.add.outer(line**2, line**2) - 2.5, [line, line])      # the circle cuts 3 · 4 grid edges
    >>> mesh.vertices.shape, mesh.cells.shape, int(mesh.cap.sum())
    ((12, 2), (12, 2), 0)
    """
    whole = Blocks(np.pad(values, 1)[None], np.full((1, values.ndim), -1), Grid.of(axes))
    return join([march(whole)])


def join(pieces: list[Piece]) -> Mesh:
    """Return the mesh of pieces, at least one, whose vertices with the same key become one."""
    starts = np.cumsum([0, *(len(piece.vertices) for piece in pieces)]).tolist()
    shared = np.concatenate([piece.shared + start for piece, start in zip(pieces, starts[:-1], strict=True)])
    keys = np.concatenate([piece.keys for piece in pieces])
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    kept = np.ones(starts[-1], dtype=bool)
    kept[shared] = False
    kept[shared[first]] = True
    number = np.cumsum(kept) - 1
    number[shared] = number[shared[first]][inverse]
    cells = np.concatenate([number[start:][piece.cells] for piece, start in zip(pieces, starts[:-1], strict=True)])
    vertices = np.concatenate([piece.vertices for piece in pieces])[kept]
    held = np.concatenate([piece.held for piece in pieces])[kept]
    mesh = Mesh(vertices, cells, np.concatenate([piece.cap for piece in pieces]), held)
    return mesh.keep(~_collapsed(cells)) if mesh.cap.any() else mesh


def _collapsed(cells: IntArray) -> BoolArray:
    """Return which cells have a vertex twice: those beyond an edge of the box, onto which they are laid."""
    return np.asarray(np.logical_or.reduce([cells[:, k] == cells[:, k - 1] for k in range(cells.shape[1])]))
