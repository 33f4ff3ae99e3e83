"""Cells of f = 0 on a grid: the pieces of its blocks joined."""

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


# Grid cells along each axis of a block, about. Smaller ones prune more, but cost more calls and Bernstein coefficients.
SIZE = {2: 128, 3: 48}
CACHED = 1 << 14  # sums at once: with the terms, 256 kB of the L2 cache
NODES = 1 << 20  # of the blocks that are marched together: 8 MB, and 9 of 48³


@dataclass(frozen=True, eq=False)
class Sampling:
    """f on a grid, to be evaluated block by block: at a node the same bits in every block that has it.

    Attributes
    ----------
    lines
        (N_x, n+1), the univariate functions at the grid lines of the first axis.
    planes
        (n+1, N_y[, N_z]), f contracted along the other axes.

    """

    lines: FloatArray
    planes: FloatArray

    @classmethod
    def of(cls, polynomial: ImplicitPolynomial, axes: list[FloatArray]) -> Self:
        """Contract all axes but the first, which take little memory."""
        first, *others = polynomial.tables(axes)
        planes = polynomial.tensor
        for table in others:  # the contracted axis goes last, so the next one comes second
            planes = np.tensordot(planes, table, axes=(1, 1))
        return cls(first, planes)

    def into(self, out: FloatArray, origin: IntArray) -> None:
        """Write f at the nodes of a block whose first is `origin`, and 0 beyond the walls.

        Term is added to term, not left to BLAS, whose last bits depend on where in a matrix a number stands: a node
        on whose sign two blocks disagreed would tear the surface.
        """
        counts = (len(self.lines), *self.planes.shape[1:])
        start, stop = np.maximum(origin, 0), np.minimum(origin + out.shape, counts)
        first, *others = _window(start, stop)
        x, part = self.lines[first], self.planes[(slice(None), *others)]
        planes = part.reshape(len(part), -1)
        total = np.empty((len(x), planes.shape[1]))
        rows = max(1, CACHED // planes.shape[1])
        room = np.empty((rows, planes.shape[1]))
        for row in range(0, len(x), rows):
            sums, factors = total[row : row + rows], x[row : row + rows, :, None]
            np.multiply(factors[:, 0], planes[0], out=sums)
            for k in range(1, len(planes)):
                sums += np.multiply(factors[:, k], planes[k], out=room[: len(sums)])
        out[_window(start - origin, stop - origin)] = total.reshape(len(x), *part.shape[1:])


def _window(start: IntArray, stop: IntArray) -> tuple[slice, ...]:
    return tuple(slice(*ends) for ends in zip(start.tolist(), stop.tolist(), strict=True))


def extract_pruned(
    polynomial: ImplicitPolynomial, axes: list[FloatArray], threads: int | None = None, size: int | None = None
) -> Mesh:
    """Return the cells of f = 0, closed along the walls, on the grid of evenly spaced raw grid lines `axes`.

    They are those of `extraction.extract` but for rounding, in another order, which `threads` do not change. `size` is
    that of the blocks, in grid cells along each axis, about.

    Raises
    ------
    InvalidOptionsError
        If f overflows in the box.

    """
    grid = Grid.of(axes)
    along = grid.counts + 1  # cells, with those beyond the walls
    cells = -(-along // np.maximum(1, np.rint(along / (size or SIZE[len(axes)])).astype(np.intp)))
    origins = _kept(polynomial, axes, cells)
    sampling, batch = Sampling.of(polynomial, axes), max(1, NODES // int(np.prod(cells + 1)))

    def piece(start: int) -> Piece:
        some = origins[start : start + batch]
        values = np.zeros((len(some), *(cells + 1)))
        for place, origin in zip(values, some, strict=True):
            sampling.into(place, origin)
        return march(Blocks(values, some, grid))

    return join(_threads.mapped(piece, range(0, max(1, len(origins)), batch), threads))


def _kept(polynomial: ImplicitPolynomial, axes: list[FloatArray], cells: IntArray) -> IntArray:
    """Return the origins (G, d) of the blocks that may have cells: f changes sign, or it may be negative at a wall."""
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
