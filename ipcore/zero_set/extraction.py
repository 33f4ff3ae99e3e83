"""The cells of f = 0 on a grid of evenly spaced lines, in one block or in many of which most are skipped.

A small grid is evaluated and marched through as a whole (`extract`). A large one is divided into blocks, and only those
are evaluated whose Bernstein coefficients allow a change of sign (`extract_pruned`); the pieces of a mesh that the
blocks give are joined at the nodes they share.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore import _threads
from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.errors import InvalidOptionsError
from ipcore.polynomial import bernstein
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.grid import Blocks, Grid, Piece
from ipcore.zero_set.marching import march
from ipcore.zero_set.mesh import Mesh

# Grid cells along each axis of a block, about. With smaller blocks more of the grid is skipped, but there are more
# calls and more Bernstein coefficients.
BLOCK_CELLS = {2: 128, 3: 48}
CACHED_SUMS = 1 << 14  # sums that are computed together: with their terms, 256 kB of the L2 cache
BATCH_NODES = 1 << 20  # of the blocks that are marched through together: 8 MB, or 9 blocks of 48³ cells


def extract(values: FloatArray, axes: list[FloatArray]) -> Mesh:
    """Return the cells of f = 0, closed along the walls of the box.

    Parameters
    ----------
    values
        f at the nodes of the grid, (N_x, N_y[, N_z]).
    axes
        The evenly spaced grid lines along each axis, raw, (N_axis,) each.

    Examples
    --------
    >>> line = np.linspace(-2.0, 2.0, 5)
    >>> mesh = extract(np.add.outer(line**2, line**2) - 2.5, [line, line])      # the circle cuts 3 · 4 grid edges
    >>> mesh.vertices.shape, mesh.cells.shape, int(mesh.cap.sum())
    ((12, 2), (12, 2), 0)

    """
    whole = Blocks(np.pad(values, 1)[None], np.full((1, values.ndim), -1), Grid.of(axes))
    return join([march(whole)])


def extract_pruned(
    polynomial: ImplicitPolynomial, axes: list[FloatArray], threads: int | None = None, size: int | None = None
) -> Mesh:
    """Return the cells of f = 0, closed along the walls, computed only in blocks of the grid that may have some.

    They are the cells that `extract` returns but for rounding, in another order, which `threads` does not change.

    Parameters
    ----------
    polynomial
        f.
    axes
        The evenly spaced grid lines along each axis, raw, (N_axis,) each.
    threads
        How many threads work; by default all that are available.
    size
        The number of grid cells along each axis of a block, about; default 128 in 2D, 48 in 3D.

    Raises
    ------
    InvalidOptionsError
        If f overflows in the box.

    """
    grid = Grid.of(axes)
    along = grid.counts + 1  # cells, with those beyond the walls
    cells = -(-along // np.maximum(1, np.rint(along / (size or BLOCK_CELLS[len(axes)])).astype(np.intp)))
    origins = _origins(polynomial, axes, cells)
    sampling, batch = Sampling.of(polynomial, axes), max(1, BATCH_NODES // int(np.prod(cells + 1)))

    def piece(start: int) -> Piece:
        some = origins[start : start + batch]
        values = np.zeros((len(some), *(cells + 1)))
        for block, origin in zip(values, some, strict=True):
            sampling.into(block, origin)
        return march(Blocks(values, some, grid))

    return join(_threads.mapped(piece, range(0, max(1, len(origins)), batch), threads))


def join(pieces: list[Piece]) -> Mesh:
    """Return the mesh of pieces, at least one: vertices with the same key become one vertex."""
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
    """Return which cells (C, d) have a vertex twice, (C,): those moved onto a wall from beyond an edge of the box."""
    return np.asarray(np.logical_or.reduce([cells[:, k] == cells[:, k - 1] for k in range(cells.shape[1])]))


@dataclass(frozen=True, eq=False)
class Sampling:
    """f on a grid, evaluated block by block; blocks that share a node get the same bits there.

    Attributes
    ----------
    lines
        (N_x, n+1), the univariate functions at the grid lines of the first axis.
    planes
        (n+1, N_y[, N_z]), the coefficients contracted with the univariate functions along the other axes.

    """

    lines: FloatArray
    planes: FloatArray

    @classmethod
    def of(cls, polynomial: ImplicitPolynomial, axes: list[FloatArray]) -> Self:
        """Contract the coefficients along all axes but the first, which takes little memory."""
        first, *others = polynomial.tables(axes)
        planes = polynomial.tensor
        for table in others:  # the contracted axis goes last, so the next one comes second
            planes = np.tensordot(planes, table, axes=(1, 1))
        return cls(first, planes)

    def into(self, out: FloatArray, origin: IntArray) -> None:
        """Write the values of f at the nodes of a block into `out` (…); beyond the walls they are 0.

        `origin` (d,) is the first node of the block. The sums are added term by term and not by BLAS, which rounds the
        same sum differently at different places of a matrix. Two blocks share nodes, and must find the same sign there:
        else the surface has a hole.
        """
        counts = (len(self.lines), *self.planes.shape[1:])
        start, stop = np.maximum(origin, 0), np.minimum(origin + out.shape, counts)
        first, *others = _window(start, stop)
        x, part = self.lines[first], self.planes[(slice(None), *others)]
        planes = part.reshape(len(part), -1)
        total = np.empty((len(x), planes.shape[1]))
        rows = max(1, CACHED_SUMS // planes.shape[1])
        scratch = np.empty((rows, planes.shape[1]))
        for row in range(0, len(x), rows):
            sums, factors = total[row : row + rows], x[row : row + rows, :, None]
            np.multiply(factors[:, 0], planes[0], out=sums)
            for k in range(1, len(planes)):
                sums += np.multiply(factors[:, k], planes[k], out=scratch[: len(sums)])
        out[_window(start - origin, stop - origin)] = total.reshape(len(x), *part.shape[1:])


def _window(start: IntArray, stop: IntArray) -> tuple[slice, ...]:
    """Return the slices from `start` (d,) to `stop` (d,)."""
    return tuple(slice(*ends) for ends in zip(start.tolist(), stop.tolist(), strict=True))


def _origins(polynomial: ImplicitPolynomial, axes: list[FloatArray], cells: IntArray) -> IntArray:
    """Return the origins (G, d) of the blocks that may have cells; `cells` (d,) is the size of a block in grid cells.

    A block may have cells if f may change its sign there, or if f may be negative and the block lies at a wall.
    """
    starts = [np.arange(-1, len(line), step) for line, step in zip(axes, cells.tolist(), strict=True)]
    ends = [
        line[np.clip([start, start + step], 0, len(line) - 1)]
        for line, start, step in zip(axes, starts, cells, strict=True)
    ]
    with np.errstate(over="ignore", invalid="ignore"):
        low, high = bernstein.ranges(polynomial, ends)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise InvalidOptionsError("the polynomial overflows in this box; take smaller bounds", ("bounds",))
    wall = np.ones(low.shape, dtype=bool)
    wall[(slice(1, -1),) * low.ndim] = False
    kept = (low < 0.0) & ((high >= 0.0) | wall)
    return np.stack([start[k] for start, k in zip(starts, np.nonzero(kept), strict=True)], axis=1)
