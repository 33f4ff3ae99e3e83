"""Cells of an octree, or of a quadtree in the plane: balanced, and with their faces.

Positions are whole numbers of a unit that is some times smaller than the smallest cell: so the middle of an edge has a
position, and cells can be halved a few times.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Self

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.proof.blocks import Blocks

SPARE_HALVINGS = 4  # how often the smallest of the given cells can be halved
SIDES = 64  # more than there are different sides


@dataclass(frozen=True, eq=False)
class Cells:
    """M cells.

    Attributes
    ----------
    low
        (M, d), the lower corner of each.
    side
        (M,), its length along each axis.
    width
        The length of the whole box, along every axis.
    origin, unit
        (d,), the lower corner of the box, and the lengths of the unit, as f takes them.

    """

    low: IntArray
    side: IntArray
    width: int
    origin: FloatArray
    unit: FloatArray

    @classmethod
    def of(cls, leaves: list[Blocks]) -> Self:
        """Return the cells of blocks of one box."""
        top = max(blocks.halvings for blocks in leaves)
        sides = [2 << (top - blocks.halvings + SPARE_HALVINGS) for blocks in leaves]
        low = [blocks.place.astype(np.int64) * side for blocks, side in zip(leaves, sides, strict=True)]
        repeated = [np.full(len(blocks), side) for blocks, side in zip(leaves, sides, strict=True)]
        first = leaves[0]
        width = first.parts * (2 << (top + SPARE_HALVINGS))
        return cls(np.concatenate(low), np.concatenate(repeated), width, first.lower, first.size / sides[0])

    def keys(self, low: IntArray | None = None) -> IntArray:
        """Return a number for each position (M, d); that of the lower corners if no others are given."""
        key, *rest = (self.low if low is None else low).T
        for column in rest:
            key = key * (self.width + 1) + column
        return np.asarray(key)

    def split(self, some: BoolArray) -> Self:
        """Return the cells with some of them halved along every axis."""
        low, side = _split(self.low, self.side, some)
        return replace(self, low=low, side=side)

    def balanced(self) -> Self:
        """Return the cells, with those halved that are more than twice as large as a neighbour."""
        low, side = self.low, self.side
        around = np.array(list(product((-1, 0, 1), repeat=low.shape[1])))
        small = int(side.min())
        while 4 * small <= side.max():
            near = (low[side == small][:, None] + small * around).reshape(-1, low.shape[1])
            large = int(side.max())
            while large > 2 * small:
                too_large = (side == large) & np.isin(self.keys(low), self.keys(near // large * large))
                low, side = _split(low, side, too_large)
                large //= 2
            small *= 2
        return replace(self, low=low, side=side)

    def corners(self) -> IntArray:
        """Return the numbers of the corners of all cells, each once, sorted."""
        d = self.low.shape[1]
        steps = np.array(list(product((0, 1), repeat=d)))
        return _distinct(self.keys((self.low[:, None] + self.side[:, None, None] * steps).reshape(-1, d)))

    def positions(self, keys: IntArray) -> FloatArray:
        """Return the places (K, d), as f takes them, of positions with these numbers (K,)."""
        base, d = self.width + 1, self.low.shape[1]
        digits = [keys // base ** (d - 1 - axis) % base for axis in range(d)]
        return np.asarray(self.origin + self.unit * np.stack(digits, axis=1))

    def find(self, low: IntArray, side: IntArray) -> IntArray:
        """Return the number (K,) of the cell with this lower corner (K, d) and this side (K,); −1 if there is none."""
        marks, order = self._sorted
        theirs = self.marked(low, side)
        at = np.minimum(np.searchsorted(marks, theirs), len(order) - 1)
        return np.where(marks[at] == theirs, order[at], -1)

    def marked(self, low: IntArray, side: IntArray) -> IntArray:
        """Return a number for each lower corner and side: of the numbers that stand for a side, a cell has one."""
        return self.keys(low) * SIDES + np.log2(np.maximum(side, 1)).astype(np.int64)

    @cached_property
    def _sorted(self) -> tuple[IntArray, IntArray]:
        """The numbers of all cells, sorted, and which cells they are."""
        marks = self.marked(self.low, self.side)
        order = np.argsort(marks)
        return marks[order], order


def _distinct(numbers: IntArray) -> IntArray:
    """Return numbers (K,) sorted and each once: `np.unique` hashes them, which takes ten times as long."""
    numbers = np.sort(numbers)
    return np.asarray(numbers[np.concatenate([[True], numbers[1:] != numbers[:-1]])])


def _split(low: IntArray, side: IntArray, some: BoolArray) -> tuple[IntArray, IntArray]:
    """Return cells of which some are replaced by their 2^d halves."""
    d = low.shape[1]
    half = side[some] // 2
    corners = np.array(list(product((0, 1), repeat=d)))
    parts = (low[some][:, None] + half[:, None, None] * corners).reshape(-1, d)
    return np.concatenate([low[~some], parts]), np.concatenate([side[~some], np.repeat(half, 2**d)])


@dataclass(frozen=True, eq=False)
class Faces:
    """The faces between cells: of two that meet, those of the smaller one. In the plane the cells are their own faces.

    Attributes
    ----------
    low, side
        (K, d) and (K,), as of cells.
    normal
        (K,), the axis that each is normal to; in the plane 2 for all.
    face, cell
        (I,) each: which face belongs to which cell, in pairs.

    """

    low: IntArray
    side: IntArray
    normal: IntArray
    face: IntArray
    cell: IntArray

    @classmethod
    def of(cls, cells: Cells) -> Self:
        """Return the faces of balanced cells."""
        count, d = cells.low.shape
        if d == 2:
            every = np.arange(count)
            return cls(cells.low, cells.side, np.full(count, 2), every, every)
        found = [_on_one_side(cells, axis, upper) for axis in range(d) for upper in (0, 1)]
        low, side, normal, own, other = (np.concatenate(column) for column in zip(*found, strict=True))
        marks = cells.marked(low, side) * d + normal
        _, one, number = np.unique(marks, return_index=True, return_inverse=True)
        behind = other >= 0
        pairs = np.concatenate([number * count + own, number[behind] * count + other[behind]])
        face, cell = np.divmod(_distinct(pairs), count)
        return cls(low[one], side[one], normal[one], face, cell)


def _on_one_side(cells: Cells, axis: int, upper: int) -> tuple[IntArray, ...]:
    """Return the lower or upper faces normal to an axis that no smaller cell divides.

    Each comes as lower corner, side, axis, the cell whose face it is, and the cell of twice its size behind it, or −1.
    """
    low, side = cells.low, cells.side
    origin = low.copy()
    origin[:, axis] += upper * side
    halves = np.array([one for one in product((0, 1), repeat=low.shape[1]) if one[axis] == 0])
    beyond = np.arange(low.shape[1]) == axis
    divided = np.zeros(len(low), dtype=bool)
    for half in halves:
        step = side[:, None] // 2 * (half - (1 - upper) * beyond)
        divided |= cells.find(origin + step, side // 2) >= 0
    own = np.flatnonzero(~divided)
    behind = origin[own] - (1 - upper) * side[own, None] * beyond
    twice = 2 * side[own]
    other = cells.find(behind // twice[:, None] * twice[:, None], twice)
    return origin[own], side[own], np.full(len(own), axis), own, other
