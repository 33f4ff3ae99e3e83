"""Marching squares and cubes through blocks of a grid: the vertices and cells of f = 0, by linear interpolation."""

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.zero_set.cases import LOOP_CENTRE, Cases, cases
from ipcore.zero_set.grid import Blocks, Grid, Piece

# Vertices keep this share of a grid edge from its ends, so that nodes where f = 0 (common: shapes with round numbers)
# do not collapse cells. Any small number does: the error is of the size of linear interpolation's, and Newton's method
# removes it.
EDGE_MARGIN = 0.01


def march(blocks: Blocks) -> Piece:
    """Return the cells of f = 0 in blocks of a grid. Cells beyond a wall are moved onto the wall, as its cap.

    >>> f, line = np.ones((1, 5, 5)), np.array([0.0, 1.0, 2.0])
    >>> f[0, 2, 2] = -1.0
    >>> piece = march(Blocks(f, np.array([[-1, -1]]), Grid.of([line, line])))
    >>> piece.vertices.tolist(), piece.cells.tolist()
    ([[0.5, 1.0], [1.5, 1.0], [1.0, 0.5], [1.0, 1.5]], [[0, 2], [3, 0], [2, 1], [1, 3]])
    """
    index, cells, moved, shared, keys = _marched(blocks)
    vertices, held, cap = _at_walls(index, cells, blocks.grid)
    held[np.flatnonzero(moved)] = True
    return Piece(vertices, held, cells, cap, shared, keys)


def march_open(values: FloatArray, grid: Grid) -> tuple[FloatArray, IntArray]:
    """Return the vertices (V, d), raw, and the cells (C, d) of f = 0 on a whole grid, left open at its walls.

    `values` (…) are those of f at the nodes.

    >>> f, line = np.ones((3, 3)), np.array([0.0, 1.0, 2.0])
    >>> f[0, 1] = -1.0
    >>> [array.tolist() for array in march_open(f, Grid.of([line, line]))]
    [[[0.5, 1.0], [0.0, 0.5], [0.0, 1.5]], [[1, 0], [0, 2]]]
    """
    origin = np.zeros((1, values.ndim), dtype=np.intp)
    index, cells, *_ = _marched(Blocks(values[None], origin, grid))
    return grid.lower + index * ((grid.upper - grid.lower) / (grid.counts - 1)), cells


def _marched(blocks: Blocks) -> tuple[FloatArray, IntArray, BoolArray, IntArray, IntArray]:
    """Return the vertices (V, d) in grid indices, the cells (C, d), and the last three results of `_edge_vertices`.

    The vertices on edges of the grid come first, then the centres of loops.
    """
    table, inside = cases(len(blocks.strides)), blocks.values < 0.0
    edges = _crossed_edges(inside)
    index, moved, shared, keys = _edge_vertices(blocks, edges)
    cells, owner = _cells(blocks, table, edges, *_crossed_cells(blocks, inside, table))
    return np.concatenate([index, _loop_centres(index, cells, owner)]), cells, moved, shared, keys


def _crossed_edges(inside: BoolArray) -> list[IntArray]:
    """Return for each axis the lower nodes (n,) of the crossed edges, in the row of nodes; `inside` (G, …) is f < 0."""
    edges = []
    for axis in range(1, inside.ndim):
        before, after = ((slice(None),) * axis + (part,) for part in (slice(-1), slice(1, None)))
        differ = np.zeros(inside.shape, dtype=bool)
        np.not_equal(inside[before], inside[after], out=differ[before])
        edges.append(np.flatnonzero(differ))
    return edges


def _edge_vertices(blocks: Blocks, edges: list[IntArray]) -> tuple[FloatArray, BoolArray, IntArray, IntArray]:
    """Return the vertices of the blocks: one for each edge of the grid on which f changes sign.

    Returns
    -------
        The vertices (E, d), in grid indices; whether each was moved onto a wall of the box (E,); the numbers (S,) of
        those that other blocks have, too; and the keys (S,) by which the same vertex of two blocks is recognised. The
        key is that of the edge. An edge that ends beyond a wall has its vertex moved to its node on the wall, and the
        key of that node.

    """
    row, d, counts = blocks.values.ravel(), len(edges), blocks.grid.counts
    index, moved, shared, keys = [], [], [], []
    for axis, nodes in enumerate(edges):
        a, b = np.abs(row[nodes]), np.abs(row[nodes + blocks.strides[axis]])
        place, at_end = blocks.grid_indices(nodes)
        vertex = place.T.astype(np.float64)
        vertex[:, axis] += np.clip(a / (a + b), EDGE_MARGIN, 1.0 - EDGE_MARGIN)
        before, after = place[axis] < 0, place[axis] == counts[axis] - 1
        place[axis] += before
        at_end[axis] = before | after
        index.append(np.clip(vertex, 0.0, counts - 1.0))
        moved.append(at_end[axis].copy())
        shared.append(at_end.any(axis=0))
        keys.append((d + 1) * np.ravel_multi_index(tuple(place), tuple(counts)) + np.where(moved[-1], d, axis))
    joined = np.flatnonzero(np.concatenate(shared))
    return np.concatenate(index), np.concatenate(moved), joined, np.concatenate(keys)[joined]


def _crossed_cells(blocks: Blocks, inside: BoolArray, table: Cases) -> tuple[IntArray, IntArray]:
    """Return the lowest corners (n,) of the grid cells that f = 0 crosses, and their rows (n,) in the table of cases.

    `inside` (G, …) is f < 0.
    """
    d = len(blocks.strides)
    code = inside.ravel().astype(np.uint8)
    for k in range(d):  # the bits of two corners, of four, of eight
        step = int(blocks.strides[d - 1 - k])
        code[:-step] |= code[step:] << (1 << k)
    crossed = np.zeros(blocks.values.shape, dtype=bool)
    whole = (slice(None), *(slice(-1),) * d)
    np.less(code.reshape(crossed.shape)[whole] - np.uint8(1), 2**2**d - 2, out=crossed[whole])  # not 0 and not all
    at = np.flatnonzero(crossed)
    codes, flags = code[at].astype(np.intp), np.zeros_like(at)
    doubtful = np.flatnonzero(table.ambiguous[codes])
    flags[doubtful] = _connected_faces(blocks, table, at[doubtful]) & table.ambiguous[codes[doubtful]]
    return at, table.row[codes, flags]


def _connected_faces(blocks: Blocks, table: Cases, at: IntArray) -> IntArray:
    """Return for grid cells the bits of the faces whose inside corners are connected, (n,).

    `at` (n,) are the lowest corners of the grid cells. The bits are right for faces whose four edges are all crossed.
    With a, c the values at the inside corners and b, d at the outside ones, the bilinear interpolant has the value
    (ac − bd)/(a + c − b − d) at its saddle. The denominator is negative, so the inside is connected where ac > bd.
    """
    value = blocks.values.ravel()[at[:, None] + blocks.corner_steps]
    a, b, c, d = np.moveaxis(value[:, table.faces], 2, 0)
    with np.errstate(over="ignore"):
        connected = np.where(a < 0.0, a * c > b * d, b * d > a * c)
    return np.asarray(connected @ (1 << np.arange(len(table.faces))))


def _cells(
    blocks: Blocks, table: Cases, edges: list[IntArray], at: IntArray, row: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the vertices (C, d) of the segments or triangles, and the crossed grid cell (C,) that each belongs to.

    Vertices are numbered in the order of `edges`; −1 is the centre of a loop. `at` and `row` (n,) are the lowest
    corners and the cases of the crossed grid cells.
    """
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
    cells[corners[:, 0] == LOOP_CENTRE, 0] = -1
    return cells, owner


def _loop_centres(index: FloatArray, cells: IntArray, owner: IntArray) -> FloatArray:
    """Return the centres (L, d) of the loops that need one, and write their numbers into the cells (C, d).

    A centre is the mean of the loop's vertices, which are rows of `index` (E, d); the numbers begin at E.
    """
    around = np.flatnonzero(cells[:, 0] < 0)
    if not len(around):
        return np.empty((0, index.shape[1]))
    loops, loop = np.unique(owner[around], return_inverse=True)
    cells[around, 0] = len(index) + loop
    sums = np.zeros((len(loops), index.shape[1]))
    np.add.at(sums, loop, index[cells[around, 1]])
    return np.asarray(sums / np.bincount(loop)[:, None])


def _at_walls(index: FloatArray, cells: IntArray, grid: Grid) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Return the vertices (V, d), raw, which coordinates lie on a wall (V, d), and which cells are caps (C,).

    Vertices on a wall get the wall's own coordinate, to the bit. `index` (V, d) are the vertices in grid indices.
    """
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
