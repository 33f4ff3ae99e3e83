"""Marching squares and cubes through blocks of a grid."""

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.zero_set.cases import MIDDLE, Cases, cases
from ipcore.zero_set.grid import Blocks, Grid, Piece

# Vertices keep this share of a grid edge from its ends, so that nodes where f = 0 (common: shapes with round numbers)
# do not collapse cells. Any small number does: the error is of the size of linear interpolation's, and polished away.
MARGIN = 0.01


def march(blocks: Blocks) -> Piece:
    """Return the cells of f = 0 in blocks of a grid. What would lie beyond a wall is laid onto it, as its cap.

    >>> f, line = np.ones((1, 5, 5)), np.array([0.0, 1.0, 2.0])
    >>> f[0, 2, 2] = -1.0
    >>> piece = march(Blocks(f, np.array([[-1, -1]]), Grid.of([line, line])))
    >>> piece.vertices.tolist(), piece.cells.tolist()
    ([[0.5, 1.0], [1.5, 1.0], [1.0, 0.5], [1.0, 1.5]], [[0, 2], [3, 0], [2, 1], [1, 3]])
    """
    index, cells, laid, shared, keys = _marched(blocks)
    vertices, held, cap = _at_walls(index, cells, blocks.grid)
    held[np.flatnonzero(laid)] = True
    return Piece(vertices, held, cells, cap, shared, keys)


def march_within(values: FloatArray, grid: Grid) -> tuple[FloatArray, IntArray]:
    """Return the vertices (V, d), raw, and cells (C, d) of f = 0 on a whole grid, with nothing laid onto its walls.

    >>> f, line = np.ones((3, 3)), np.array([0.0, 1.0, 2.0])
    >>> f[0, 1] = -1.0
    >>> [array.tolist() for array in march_within(f, Grid.of([line, line]))]
    [[[0.5, 1.0], [0.0, 0.5], [0.0, 1.5]], [[1, 0], [0, 2]]]
    """
    origin = np.zeros((1, values.ndim), dtype=np.intp)
    index, cells, *_ = _marched(Blocks(values[None], origin, grid))
    return grid.lower + index * ((grid.upper - grid.lower) / (grid.counts - 1)), cells


def _marched(blocks: Blocks) -> tuple[FloatArray, IntArray, BoolArray, IntArray, IntArray]:
    """Return vertices in steps of the grid, cells, and of vertices on edges: which are laid, which shared, and keys."""
    table, inside = cases(len(blocks.strides)), blocks.values < 0.0
    edges = _crossed(inside)
    index, laid, shared, keys = _on_edges(blocks, edges)
    cells, owner = _cells(blocks, table, edges, *_rows(blocks, inside, table))
    return np.concatenate([index, _middles(index, cells, owner)]), cells, laid, shared, keys


def _crossed(inside: BoolArray) -> list[IntArray]:
    """Return for each axis the lower nodes of the crossed edges, in the row of nodes."""
    edges = []
    for axis in range(1, inside.ndim):
        before, after = ((slice(None),) * axis + (part,) for part in (slice(-1), slice(1, None)))
        differ = np.zeros(inside.shape, dtype=bool)
        np.not_equal(inside[before], inside[after], out=differ[before])
        edges.append(np.flatnonzero(differ))
    return edges


def _on_edges(blocks: Blocks, edges: list[IntArray]) -> tuple[FloatArray, BoolArray, IntArray, IntArray]:
    """Return the vertices on crossed edges in steps of the grid, which are laid onto walls, which are shared, and keys.

    The key is that of the edge, or if it ends beyond a wall that of its node on the wall, where all such are laid.
    """
    row, d, counts = blocks.values.ravel(), len(edges), blocks.grid.counts
    index, laid, joins, keys = [], [], [], []
    for axis, nodes in enumerate(edges):
        a, b = np.abs(row[nodes]), np.abs(row[nodes + blocks.strides[axis]])
        place, rim = blocks.places(nodes)
        part = place.T.astype(np.float64)
        part[:, axis] += np.clip(a / (a + b), MARGIN, 1.0 - MARGIN)
        before, after = place[axis] < 0, place[axis] == counts[axis] - 1
        place[axis] += before
        rim[axis] = before | after
        index.append(np.clip(part, 0.0, counts - 1.0))
        laid.append(rim[axis].copy())
        joins.append(rim.any(axis=0))
        keys.append((d + 1) * np.ravel_multi_index(tuple(place), tuple(counts)) + np.where(laid[-1], d, axis))
    shared = np.flatnonzero(np.concatenate(joins))
    return np.concatenate(index), np.concatenate(laid), shared, np.concatenate(keys)[shared]


def _rows(blocks: Blocks, inside: BoolArray, table: Cases) -> tuple[IntArray, IntArray]:
    """Return the lowest corners of the cells that f = 0 crosses, and their rows in the table of cases."""
    d = len(blocks.strides)
    code = inside.ravel().astype(np.uint8)
    for k in range(d):  # the bits of two corners, of four, of eight
        step = int(blocks.strides[d - 1 - k])
        code[:-step] |= code[step:] << (1 << k)
    crossed = np.zeros(blocks.values.shape, dtype=bool)
    whole = (slice(None), *(slice(-1),) * d)
    np.less(code.reshape(crossed.shape)[whole] - np.uint8(1), 2**2**d - 2, out=crossed[whole])  # neither 0 nor all
    at = np.flatnonzero(crossed)
    codes, flags = code[at].astype(np.intp), np.zeros_like(at)
    doubtful = np.flatnonzero(table.ambiguous[codes])
    flags[doubtful] = _together(blocks, table, at[doubtful]) & table.ambiguous[codes[doubtful]]
    return at, table.row[codes, flags]


def _together(blocks: Blocks, table: Cases, at: IntArray) -> IntArray:
    """Return the bits of the faces on which the inside hangs together, if all four edges are crossed.

    With a, c the values at the inside corners and b, d at the outside ones, the bilinear interpolant's value at its
    saddle is (ac − bd)/(a + c − b − d), where the denominator is negative.
    """
    value = blocks.values.ravel()[at[:, None] + blocks.corner_steps]
    a, b, c, d = np.moveaxis(value[:, table.faces], 2, 0)
    with np.errstate(over="ignore"):
        joined = np.where(a < 0.0, a * c > b * d, b * d > a * c)
    return np.asarray(joined @ (1 << np.arange(len(table.faces))))


def _cells(
    blocks: Blocks, table: Cases, edges: list[IntArray], at: IntArray, row: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the vertices of segments or triangles, −1 for the middle of a loop, and to which of `at` they belong."""
    size = blocks.values.size
    number = np.empty(len(edges) * size, dtype=np.int32)
    ordered = np.concatenate([axis * size + nodes for axis, nodes in enumerate(edges)])
    number[ordered] = np.arange(len(ordered))
    count = table.count[row]
    owner = np.repeat(np.arange(len(at)), count)
    nth = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    corners = table.corners[row[owner], nth]
    low, axis = table.edges.T
    step = np.append(axis * size + blocks.corner_steps[low], 0)
    cells = number[at[owner, None] + step[corners]].astype(np.intp)
    cells[corners[:, 0] == MIDDLE, 0] = -1
    return cells, owner


def _middles(index: FloatArray, cells: IntArray, owner: IntArray) -> FloatArray:
    """Return the middles of loops that have one, and number them in the cells."""
    around = np.flatnonzero(cells[:, 0] < 0)
    if not len(around):
        return np.empty((0, index.shape[1]))
    of, which = np.unique(owner[around], return_inverse=True)
    cells[around, 0] = len(index) + which
    sums = np.zeros((len(of), index.shape[1]))
    np.add.at(sums, which, index[cells[around, 1]])
    return np.asarray(sums / np.bincount(which)[:, None])


def _at_walls(index: FloatArray, cells: IntArray, grid: Grid) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Return the vertices, raw, exactly on the walls where they lie on one; which coordinates do; and the caps."""
    last = grid.counts - 1
    low, high = index == 0.0, index == last
    vertices = grid.lower + index * ((grid.upper - grid.lower) / last)
    held: BoolArray = low | high
    if not held.any():
        return vertices, held, np.zeros(len(cells), dtype=bool)
    np.copyto(vertices, grid.lower, where=low)
    np.copyto(vertices, grid.upper, where=high)
    cap = np.zeros(len(cells), dtype=bool)
    for wall in (*low.T, *high.T):  # column by column: numpy is slow at many sums of three
        if wall.any():
            cap |= np.logical_and.reduce([wall[corner] for corner in cells.T])
    return vertices, held, cap
