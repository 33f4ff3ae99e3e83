"""The grid of a box, blocks of it in which cells are found, and the pieces of a mesh that the blocks give.

The grid has one more layer of nodes around it, at index −1 and N along each axis, and blocks may extend farther. Nodes
beyond the walls count as outside: so surfaces are closed along the walls of the box, and all blocks have one shape.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.errors import InvalidOptionsError
from ipcore.polynomial.implicit import ImplicitPolynomial

# Grid points along the longest axis. At degree 12 these take 0.01 s and 0.1 s, and the length of a bumpy circle comes
# out 1e-5 too small, the area of a bumpy sphere 4e-4.
DEFAULT_RESOLUTION = {2: 256, 3: 96}
FEWEST_LINES = 4  # grid points along an axis


def grid_lines(polynomial: ImplicitPolynomial, bounds: FloatArray | None, resolution: int | None) -> list[FloatArray]:
    """Return the evenly spaced grid lines of each axis, raw, (N_axis,) each; the grid cells are near-cubic.

    Parameters
    ----------
    polynomial
        f.
    bounds
        (2, d), the corners of the box, raw; by default the polynomial's own bounds.
    resolution
        The number of grid lines along the longest axis; default 256 in 2D, 96 in 3D.

    Raises
    ------
    InvalidOptionsError
        If the box is empty or not finite, or the resolution less than 4.

    """
    d = polynomial.dimension
    box = polynomial.bounds if bounds is None else np.asarray(bounds, dtype=np.float64)
    count = DEFAULT_RESOLUTION[d] if resolution is None else resolution
    if box.shape != (2, d) or not np.isfinite(box).all() or not np.all(box[0] < box[1]):
        raise InvalidOptionsError(f"bounds must be a lower and an upper corner of {d} coordinates", ("bounds",))
    if count < FEWEST_LINES:
        raise InvalidOptionsError(f"resolution must be at least {FEWEST_LINES}, not {count}", ("resolution",))
    sides = box[1] - box[0]
    counts = np.maximum(FEWEST_LINES, 1 + np.rint((count - 1) * sides / sides.max())).astype(int)
    return [np.linspace(low, high, n) for (low, high), n in zip(box.T, counts, strict=True)]


@dataclass(frozen=True, eq=False)
class Grid:
    """A grid of evenly spaced lines.

    Attributes
    ----------
    lower, upper
        (d,), the corners of the box, raw.
    counts
        (d,), the number of nodes along each axis.

    """

    lower: FloatArray
    upper: FloatArray
    counts: IntArray

    @classmethod
    def of(cls, axes: list[FloatArray]) -> Self:
        """Return the grid with these grid lines, raw, (N_axis,) for each axis."""
        lower, upper = np.array([line[[0, -1]] for line in axes]).T
        return cls(lower, upper, np.array([len(line) for line in axes]))


@dataclass(frozen=True, eq=False)
class Blocks:
    """G blocks of a grid, all of one shape. Neighbouring blocks share the nodes between them.

    Attributes
    ----------
    values
        (G, …), f at the nodes of each block, and 0 beyond the walls. The array is contiguous, for it is also read as
        one row of nodes, in C order.
    origins
        (G, d), the grid indices of the first node of each block, from −1.
    grid
        The grid that the blocks are part of.

    """

    values: FloatArray
    origins: IntArray
    grid: Grid

    @property
    def strides(self) -> IntArray:
        """Return the steps (d,) in the row of nodes from a node to the next along each axis."""
        return np.array(self.values.strides[1:]) // self.values.itemsize

    @property
    def corner_steps(self) -> IntArray:
        """Return the steps (2^d,) in the row of nodes from the lowest corner of a cell to each of its corners."""
        digits = np.arange(len(self.strides))[::-1]
        return np.asarray((np.arange(2 ** len(digits))[:, None] >> digits & 1) @ self.strides)

    def grid_indices(self, nodes: IntArray) -> tuple[IntArray, BoolArray]:
        """Return the grid indices (d, n) of nodes, given by their numbers (n,) in the row of nodes.

        Also returns for each axis whether a node is the first or the last one of its block, (d, n).
        """
        block, *local = np.unravel_index(nodes, self.values.shape)
        ends = [(x == 0) | (x == n - 1) for x, n in zip(local, self.values.shape[1:], strict=True)]
        return np.stack(local) + self.origins.T[:, block], np.stack(ends)


@dataclass(frozen=True, eq=False)
class Piece:
    """The cells of some blocks, with what is needed to join them to those of other blocks.

    Attributes
    ----------
    vertices, held, cells, cap
        As in `Mesh`: (V, d), (V, d), (C, d) and (C,).
    shared
        (S,), the vertices that may occur again, in this piece or in others.
    keys
        (S,), their keys: vertices with the same key are the same vertex.

    """

    vertices: FloatArray
    held: BoolArray
    cells: IntArray
    cap: BoolArray
    shared: IntArray
    keys: IntArray
