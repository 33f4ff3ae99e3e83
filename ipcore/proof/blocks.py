"""A polynomial on the blocks of a box, halved again and again, in Chebyshev products of each block.

On a block f = Σ c_ijk T_i(r) T_j(s) T_k(t) with −1 ≤ r, s, t ≤ 1. On a small block the coefficients fall off fast:
those of high degree are left out, and as |T_i| ≤ 1, what they amount to is added to the *slack* (Chebyshev models:
Brisebarre and Joldeş, Chebyshev interpolation polynomial-based tools for rigorous computing, ISSAC 2010). For bounds
the others are written in Bernstein polynomials (see `enclosure`): f lies between the least and the greatest coefficient
in these, give or take the slack.

The slack also bounds all rounding, so that the bounds hold for the polynomial with exactly the delivered coefficients,
and for its values as they are computed in doubles.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.proof.enclosure import Enclosure, along_axis
from ipcore.proof.intervals import halving
from ipcore.proof.rounding import EPSILON
from ipcore.proof.weights import Weights

CHUNK = 2**16  # coefficients that are treated together: half a megabyte, which stays in the processor's cache
# What is left out of the coefficients of a block, as a share of the range of f on it, adds up over halvings.
LEFT_OUT = 1e-5
STALE = 1e-2  # with more slack than this share of the range, the coefficients are to be computed afresh
# What is left out for bounds of values and of slopes, as a share of the range of f.
FOR_VALUES, FOR_SLOPES = 1e-2, 1e-3
ROUNDED = 1e-14  # by how much places and distances may be off, as a share of the coordinates
SUMMED = 1.0 + 1e-11  # by what factor a sum of absolute values may be larger than it is computed


@dataclass(frozen=True, eq=False)
class Blocks:
    """B blocks of the same size.

    Attributes
    ----------
    coefficients
        (n+1, …, B), the Chebyshev coefficients of f on each.
    place
        (B, d), which block of the lattice of such blocks each is.
    halvings
        How often the first blocks were halved, along every axis.
    slack
        (B,), how much f may differ from these coefficients' polynomial, as it is and as it is computed.
    slope_slack
        (B, d), how much its derivatives ∂f/∂x_k may differ.
    lower, size
        (d,), the lower corner of the lattice, and the size of these blocks.
    parts
        How many first blocks there were along each axis.

    """

    coefficients: FloatArray
    place: FloatArray
    halvings: int
    slack: FloatArray
    slope_slack: FloatArray
    lower: FloatArray
    size: FloatArray
    parts: int

    def __len__(self) -> int:
        """Return B."""
        return len(self.place)

    def __getitem__(self, some: BoolArray | slice) -> Self:
        """Return some of the blocks."""
        return replace(
            self,
            coefficients=self.coefficients[..., some],
            place=self.place[some],
            slack=self.slack[some],
            slope_slack=self.slope_slack[some],
        )

    @classmethod
    def together(cls, some: Sequence[Self]) -> Self:
        """Return blocks of one size and degree together."""
        return replace(
            some[0],
            coefficients=np.concatenate([blocks.coefficients for blocks in some], axis=-1),
            place=np.concatenate([blocks.place for blocks in some]),
            slack=np.concatenate([blocks.slack for blocks in some]),
            slope_slack=np.concatenate([blocks.slope_slack for blocks in some]),
        )

    @property
    def middle(self) -> FloatArray:
        """Return the middle of each block, (B, d)."""
        return self.lower + (self.place + 0.5) * self.size

    @property
    def radius(self) -> float:
        """Return half of a block's diagonal, and more than its middle and places near it may be rounded."""
        upper = self.lower + self.size * self.parts * 2**self.halvings
        rounding = ROUNDED * float(np.maximum(np.abs(self.lower), np.abs(upper)).max())
        return float(np.linalg.norm(self.size)) / 2.0 * (1.0 + 1e-9) + rounding

    @property
    def degree(self) -> int:
        """Return n, the degree in each variable up to which there are coefficients."""
        return len(self.coefficients) - 1

    @property
    def _rows(self) -> tuple[int, int]:
        """The shape with one row for each product and one column for each block."""
        return (self.degree + 1) ** len(self.size), len(self)

    @property
    def _weights(self) -> Weights:
        """The weights that bound f and its derivatives."""
        return Weights.of(len(self.size), self.degree)

    @cached_property
    def _sizes(self) -> FloatArray:
        """The absolute values of the coefficients, one row for each product, ((n+1)^d, B)."""
        return np.abs(self.coefficients).reshape(self._rows)

    def enclosed(self) -> Enclosure:
        """Return the bounds by Bernstein coefficients."""
        return Enclosure.of(self.coefficients, self._weights)

    def without_coefficients(self) -> Self:
        """Return the blocks as places only, which take little memory."""
        return replace(self, coefficients=self.coefficients[:0])

    def chunks(self) -> Iterator[Self]:
        """Yield the blocks in parts of bounded memory."""
        step = max(1, CHUNK // (self.degree + 1) ** len(self.size))
        for start in range(0, len(self), step):
            yield self[start : start + step]

    def may_vanish(self) -> BoolArray:
        """Return the blocks on which f may have a zero, (B,)."""
        sizes = self._sizes
        # as |T_i| ≤ 1; what is not a number may be 0
        may = np.asarray(~(sizes[0] > SUMMED * (self._weights.beyond[0] @ sizes) + self.slack))
        if may.any():
            some = self[may].reduced(FOR_VALUES)
            may[may] = some.enclosed().may_vanish(some.slack)
        return may

    def touch_walls(self) -> BoolArray:
        """Return the blocks that touch a wall of the box, (B,)."""
        last = self.parts * 2**self.halvings - 1
        return np.asarray(((self.place == 0.0) | (self.place == last)).any(axis=1))

    def vanish(self) -> BoolArray:
        """Return the blocks at whose corners f has both signs, (B,): it has zeros there."""
        return self.enclosed().vanish(self.slack)

    def is_stale(self) -> BoolArray:
        """Return the blocks whose slack is large beside the range of f, (B,)."""
        return np.asarray(self.slack > STALE * (self._weights.beyond[0] @ self._sizes))

    def slopes(self) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of ∂f/∂x_k on each block, (B, d) each."""
        some = self.reduced(FOR_SLOPES)
        bounds = some.enclosed()
        low, high = (np.stack(side, axis=1) for side in zip(*map(bounds.slopes, range(len(self.size))), strict=True))
        return low / self.size - some.slope_slack, high / self.size + some.slope_slack

    def reduced(self, share: float) -> Self:
        """Return the blocks without coefficients of high degree that on none amount to more than a share of f's range.

        |T_i| ≤ 1 and |T_i'| ≤ i²; sums of absolute values are rounded.
        """
        weights, sizes = self._weights, self._sizes
        left_out = weights.beyond @ sizes
        few = (left_out[1:] <= share * left_out[0]).all(axis=1)
        return self.up_to(1 + int(few.argmax())) if few.any() else self

    def up_to(self, degree: int) -> Self:
        """Return the blocks without the coefficients of a higher degree, which go into the slack."""
        if degree >= self.degree:
            return self
        weights = self._weights
        out = weights.beyond[degree]
        return replace(
            self,
            coefficients=np.ascontiguousarray(self.coefficients[(slice(degree + 1),) * len(self.size)]),
            slack=self.slack + SUMMED * (out @ self._sizes),
            slope_slack=self.slope_slack + SUMMED * ((out * weights.squares) @ self._sizes).T * (2.0 / self.size),
        )

    def halved(self) -> Self:
        """Return the 2^d parts of each block, halved along one axis after the other.

        Parts of halves on which f has no zero are left out.
        """
        blocks = self
        for axis in range(len(self.size)):
            blocks = blocks if axis == 0 else blocks[blocks.may_vanish()]
            blocks = blocks.halved_along(axis)
        return replace(blocks, halvings=self.halvings + 1)

    def halved_along(self, axis: int) -> Self:
        """Return the halves of the blocks along an axis: all lower ones, then all upper ones.

        With T_k = Σ X_ik T_i on a half, Σ X_ik² ≤ 2, so Σ |X_ik| ≤ √(2n + 2); that bounds the rounding of the sums.
        """
        n, along = self.degree, np.arange(len(self.size)) == axis
        halves = [along_axis(half, self.coefficients, axis) for half in halving(n)]
        place = np.where(along, 2.0 * self.place, self.place)
        size = np.where(along, self.size / 2.0, self.size)
        added = np.sqrt(2.0 * n + 2.0) * (n + 3) * EPSILON * self._sizes.sum(axis=0)
        return replace(
            self,
            coefficients=np.concatenate(halves, axis=-1),
            place=np.concatenate([place, place + along]),
            slack=np.tile(self.slack + added, 2),
            slope_slack=np.tile(self.slope_slack + n**2 * added[:, None] * (2.0 / size), (2, 1)),
            size=size,
        )
