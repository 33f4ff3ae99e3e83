"""Blocks of a grid, on which cells are found, and the pieces of a mesh that come out of them.

The grid has layers of nodes more around it, at −1 and from N along each axis, which count as outside: so surfaces close
at the walls of the box, and all blocks can have one shape.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Grid:
    """A grid of evenly spaced lines.

    Attributes
    ----------
    lower, upper
        (d,), the corners of the box, raw.
    counts
        (d,), nodes along each axis.

    """

    lower: FloatArray
    upper: FloatArray
    counts: IntArray

    @classmethod
    def of(cls, axes: list[FloatArray]) -> Self:
        """Return the grid of these raw grid lines."""
        lower, upper = np.array([line[[0, -1]] for line in axes]).T
        return cls(lower, upper, np.array([len(line) for line in axes]))


@dataclass(frozen=True, eq=False)
class Blocks:
    """Some blocks, all of one shape. Neighbours have the nodes between them in common.

    Attributes
    ----------
    values
        (G, …), f at the nodes of each, and 0 beyond the walls; contiguous, for they are also read as one row.
    origins
        (G, d), where the first node of each stands in the grid, from −1.
    grid
        What they are blocks of.

    """

    values: FloatArray
    origins: IntArray
    grid: Grid

    @property
    def strides(self) -> IntArray:
        """Return the steps (d,) in the row from a node to the next along each axis."""
        return np.array(self.values.strides[1:]) // self.values.itemsize

    @property
    def corner_steps(self) -> IntArray:
        """Return the steps (2^d,) in the row from a cell's lowest corner to each of them."""
        digits = np.arange(len(self.strides))[::-1]
        return np.asarray((np.arange(2 ** len(digits))[:, None] >> digits & 1) @ self.strides)

    def places(self, nodes: IntArray) -> tuple[IntArray, BoolArray]:
        """Return where nodes (n,) of the row stand in the grid, (d, n), and whether on a rim of the block, (d, n)."""
        block, *local = np.unravel_index(nodes, self.values.shape)
        rim = [(x == 0) | (x == n - 1) for x, n in zip(local, self.values.shape[1:], strict=True)]
        return np.stack(local) + self.origins.T[:, block], np.stack(rim)


@dataclass(frozen=True, eq=False)
class Piece:
    """Cells of some blocks, as in `Mesh`, and where they join those of others.

    Attributes
    ----------
    vertices, held
        (V, d)
    cells
        (C, d)
    cap
        (C,)
    shared
        (S,), vertices that are one with those of the same key, in this piece or in others.
    keys
        (S,), their keys.

    """

    vertices: FloatArray
    held: BoolArray
    cells: IntArray
    cap: BoolArray
    shared: IntArray
    keys: IntArray
