"""Bernstein coefficients of a polynomial on the blocks of a box, halved again and again, with a bound of all rounding.

A polynomial's values on a block lie between its least and its greatest coefficient in products of Bernstein polynomials
there (see `polynomial.bernstein`). De Casteljau's algorithm gives the coefficients on the two halves of a block: each
is a mean of those on the block, with the weights C(i, j)/2^i, which doubles hold exactly.

*Slack* bounds the rounding, so that the bounds hold for the polynomial with exactly these coefficients, and for its
values as they are computed in doubles, term by term. With Σ = Σ |a_ijk| X_i Y_j Z_k, where X_i is the greatest
coefficient of the i-th function on the block, the coefficients on the first blocks are off by d (n + 2) ε Σ at most,
and by the roundings of the functions' own coefficients; a computed value by (m + 3n + 4) ε Σ: n products for each of m
terms, m − 1 sums, two roundings in each variable. Each halving adds (n + 2) ε times the greatest coefficient.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from math import comb
from typing import Self

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.polynomial import bernstein, evaluation, graded
from ipcore.polynomial.implicit import ImplicitPolynomial

EPSILON = float(np.finfo(float).eps)
# By how much the box of the blocks is larger than the bounds, as a share: places on the walls have rounded variables.
BOX_GROWTH = 2.0**-30
CHUNK = 2**21  # coefficients that are treated together: 16 MB


@dataclass(frozen=True, eq=False)
class Blocks:
    """B blocks of the same size.

    Attributes
    ----------
    coefficients
        (B, n+1, …), the Bernstein coefficients of f on each.
    place
        (B, d), which block of the lattice of such blocks each is.
    halvings
        How often the first blocks were halved, along every axis.
    slack
        (B,), a bound of the rounding in each of the coefficients, and in values of f.
    lower, size
        (d,), the lower corner of the lattice, and the size of these blocks.
    parts
        How many first blocks there were along each axis.

    """

    coefficients: FloatArray
    place: FloatArray
    halvings: int
    slack: FloatArray
    lower: FloatArray
    size: FloatArray
    parts: int

    @classmethod
    def of(cls, polynomial: ImplicitPolynomial, parts: int) -> Self:
        """Return the first blocks: `parts` along each axis of the polynomial's bounds."""
        n, d = polynomial.degree, polynomial.dimension
        grown = polynomial.bounds + BOX_GROWTH * np.diff(polynomial.bounds, axis=0) * np.array([[-1.0], [1.0]])
        edges = [np.linspace(low, high, parts + 1) for low, high in grown.T]
        variables = [polynomial.variable(edge, axis) for axis, edge in enumerate(edges)]
        ends = [np.stack([t[:-1], t[1:]]) for t in variables]
        tables = [bernstein.matrices(polynomial.basis, n, pair) for pair in ends]
        B = evaluation.along_axes(polynomial.tensor, [table.reshape(-1, n + 1) for table in tables])
        B = B.reshape((parts, n + 1) * d).transpose(*range(0, 2 * d, 2), *range(1, 2 * d, 2))
        return cls(
            np.ascontiguousarray(B.reshape(-1, *(n + 1,) * d)),
            np.indices((parts,) * d).reshape(d, -1).T.astype(float),
            0,
            _first_slack(polynomial, tables, ends).ravel(),
            grown[0],
            (grown[1] - grown[0]) / parts,
            parts,
        )

    def __len__(self) -> int:
        """Return B."""
        return len(self.place)

    def __getitem__(self, some: BoolArray | slice) -> "Blocks":
        """Return some of the blocks."""
        coefficients, place, slack = self.coefficients[some], self.place[some], self.slack[some]
        return replace(self, coefficients=coefficients, place=place, slack=slack)

    @property
    def _flat(self) -> FloatArray:
        """The coefficients of each block in a row, (B, (n+1)^d)."""
        return self.coefficients.reshape(len(self), int(np.prod(self.coefficients.shape[1:])))

    @property
    def middle(self) -> FloatArray:
        """Return the middle of each block, (B, d)."""
        return self.lower + (self.place + 0.5) * self.size

    @property
    def radius(self) -> float:
        """Return half of a block's diagonal, rounded up."""
        return float(np.linalg.norm(self.size)) / 2.0 * (1.0 + 1e-9)

    def chunks(self) -> Iterator["Blocks"]:
        """Yield the blocks in parts of bounded memory."""
        step = max(1, CHUNK // int(np.prod(self.coefficients.shape[1:])))
        for start in range(0, len(self), step):
            yield self[start : start + step]

    def may_vanish(self) -> BoolArray:
        """Return the blocks on which f may have a zero, (B,)."""
        flat = self._flat
        return np.asarray((flat.min(axis=1) <= self.slack) & (flat.max(axis=1) >= -self.slack))

    def touch_walls(self) -> BoolArray:
        """Return the blocks that touch a wall of the box, (B,)."""
        last = self.parts * 2**self.halvings - 1
        return np.asarray(((self.place == 0.0) | (self.place == last)).any(axis=1))

    def vanish(self) -> BoolArray:
        """Return the blocks at whose corners f has both signs, (B,): it has zeros there."""
        ends = slice(None, None, self.coefficients.shape[1] - 1)  # the first and the last along each axis
        corners = self.coefficients[(slice(None), *(ends,) * len(self.size))].reshape(len(self), 2 ** len(self.size))
        return np.asarray((corners.min(axis=1) < -self.slack) & (corners.max(axis=1) > self.slack))

    def halved(self) -> "Blocks":
        """Return the 2^d parts of each block that still may have a zero, halved along one axis after the other."""
        blocks = self
        for axis in range(len(self.size)):
            blocks = blocks._halved(axis)
            blocks = blocks[blocks.may_vanish()]
        return replace(blocks, halvings=self.halvings + 1)

    def _halved(self, axis: int) -> "Blocks":
        """Return the halves of the blocks along an axis: all lower ones, then all upper ones."""
        n, flat = self.coefficients.shape[1] - 1, self._flat
        rows = self.coefficients.reshape(len(self) * (n + 1) ** axis, n + 1, (n + 1) ** (len(self.size) - axis - 1))
        halves = np.empty((2, *self.coefficients.shape))
        for half, weights in zip(halves, halving(n), strict=True):
            np.matmul(weights, rows, out=half.reshape(rows.shape))
        along = np.arange(len(self.size)) == axis
        place = np.where(along, 2.0 * self.place, self.place)
        added = (n + 2) * EPSILON * np.maximum(-flat.min(axis=1), flat.max(axis=1))
        return replace(
            self,
            coefficients=halves.reshape(-1, *self.coefficients.shape[1:]),
            place=np.concatenate([place, place + along]),
            slack=np.tile(self.slack + added, 2),
            size=np.where(along, self.size / 2.0, self.size),
        )

    def slopes(self) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of ∂f/∂x_k on each block, (B, d) each.

        The derivative along an axis has the Bernstein coefficients n (b_{j+1} − b_j) / size. Each b is off by the
        slack, and their difference is rounded.
        """
        n, low, high = self.coefficients.shape[1] - 1, np.empty(self.place.shape), np.empty(self.place.shape)
        for axis, size in enumerate(self.size):
            steps = np.diff(self.coefficients, axis=axis + 1)
            steps = steps.reshape(len(self), int(np.prod(steps.shape[1:])))
            low[:, axis] = n / size * (steps.min(axis=1) - 3.0 * self.slack)
            high[:, axis] = n / size * (steps.max(axis=1) + 3.0 * self.slack)
        return low, high


def _first_slack(polynomial: ImplicitPolynomial, tables: list[FloatArray], ends: list[FloatArray]) -> FloatArray:
    """Return the slack of the first blocks, (parts, …), from the Bernstein coefficients of the functions there."""
    n, d, size = polynomial.degree, polynomial.dimension, np.abs(polynomial.tensor)
    largest = [np.abs(table).max(axis=1) for table in tables]
    out = (d * (n + 2) + roundings(polynomial)) * EPSILON * evaluation.along_axes(size, largest)
    for axis, pair in enumerate(ends):
        off = bernstein.matrix_roundings(polynomial.basis, n, pair)
        out += evaluation.along_axes(size, [off if k == axis else table for k, table in enumerate(largest)])
    return np.asarray(1.01 * out)  # with the products of two such errors


def roundings(polynomial: ImplicitPolynomial) -> int:
    """Return m + 3n + 4: how many roundings, each of ε/2 of Σ |a_ijk X_i Y_j Z_k| at most, a computed value has."""
    return graded.count(polynomial.dimension, polynomial.degree) + 3 * polynomial.degree + 4


def rounding(polynomial: ImplicitPolynomial, x: FloatArray) -> FloatArray:
    """Return by how much values of f at places x (K, d), as they are computed in doubles, may be off, (K,)."""
    tables = [np.abs(table.T) for table in polynomial.tables([np.ascontiguousarray(column) for column in x.T])]
    total = evaluation.scattered(np.abs(polynomial.tensor)[None], tables)[0]
    return np.asarray(roundings(polynomial) * EPSILON * total)


@lru_cache(maxsize=64)
def halving(degree: int) -> tuple[FloatArray, FloatArray]:
    """Return the matrices (n+1, n+1) that map Bernstein coefficients to those on the lower and on the upper half.

    >>> [half.tolist() for half in halving(1)]
    [[[1.0, 0.0], [0.5, 0.5]], [[0.5, 0.5], [0.0, 1.0]]]
    """
    lower = np.array([[comb(i, j) / 2**i for j in range(degree + 1)] for i in range(degree + 1)])
    return lower, np.ascontiguousarray(lower[::-1, ::-1])
