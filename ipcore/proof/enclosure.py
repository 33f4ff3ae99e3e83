"""Bounds of polynomials and of their derivatives on −1 … 1, from Chebyshev coefficients, by way of Bernstein's."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.proof.intervals import to_bernstein
from ipcore.proof.rounding import EPSILON
from ipcore.proof.weights import Weights


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Bernstein coefficients of B polynomials: each lies between its least and its greatest one.

    Attributes
    ----------
    coefficients
        (n+1, …, B).
    rounding
        (B,), by how much each may be off.

    """

    coefficients: FloatArray
    rounding: FloatArray

    @classmethod
    def of(cls, chebyshev: FloatArray, weights: Weights) -> Self:
        """Take Chebyshev coefficients (n+1, …, B) and their weights.

        Along each of d axes they are multiplied by a matrix whose entries are rounded once; each sum of n + 1 products
        has n + 2 roundings more.
        """
        n, d, out = len(chebyshev) - 1, chebyshev.ndim - 1, chebyshev
        for axis in range(d):
            out = along_axis(to_bernstein(n), out, axis)
        sizes = np.abs(chebyshev).reshape((n + 1) ** d, chebyshev.shape[-1])
        return cls(out, d * (n + 3) * EPSILON * (weights.largest @ sizes))

    def may_vanish(self, slack: FloatArray) -> BoolArray:
        """Return which polynomials, give or take a slack (B,), may have a zero, (B,)."""
        least, greatest = _extremes(self.coefficients)
        off = self.rounding + slack
        return np.asarray(~((least > off) | (greatest < -off)))  # so that what is not a number may be 0

    def vanish(self, slack: FloatArray) -> BoolArray:
        """Return which have both signs at the corners, (B,): first and last coefficients are values there."""
        ends = slice(None, None, len(self.coefficients) - 1)
        least, greatest = _extremes(self.coefficients[(ends,) * (self.coefficients.ndim - 1)])
        off = self.rounding + slack
        return np.asarray((least < -off) & (greatest > off))

    def slopes(self, axis: int) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of the derivatives along an axis, as if the interval had the length 1, (B,).

        Their Bernstein coefficients are n (b_{j+1} − b_j), off by both and by the rounding of the difference.
        """
        n = len(self.coefficients) - 1
        least, greatest = _extremes(np.diff(self.coefficients, axis=axis))
        return n * (least - 3.0 * self.rounding), n * (greatest + 3.0 * self.rounding)


def along_axis(matrix: FloatArray, coefficients: FloatArray, axis: int) -> FloatArray:
    """Return coefficients (n+1, …, B) multiplied along one axis by a matrix (n+1, n+1)."""
    rows = coefficients.reshape(*coefficients.shape[: axis + 1], int(np.prod(coefficients.shape[axis + 1 :])))
    return np.asarray(np.matmul(matrix, rows).reshape(coefficients.shape))


def _extremes(coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and the greatest along all axes but the last, (B,) each."""
    axes = tuple(range(coefficients.ndim - 1))
    return coefficients.min(axis=axes), coefficients.max(axis=axes)
