r"""The whole of a linear system in a triangle: R and b̃ of M = QR, without Q, and without M ever being held.

    ‖M a − b‖² = ‖R a − b̃‖² + ρ²

for every prefix of a, so that whatever can be asked of M and b can be asked of R and b̃, which are small. Two ways lead
there: the Cholesky factor of MᵀM, which squares the condition of M, and row chunks factored one below the other.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ipcore._typing import FloatArray

BLOCK = 32  # columns in LAPACK's inner block: of 16, 32 and 64 the fastest for 90 to 1,000 columns


@dataclass(frozen=True, eq=False)
class RFactor:
    """R (m, m), b̃ (m,) and ρ, with the number of rows of M.

    Attributes
    ----------
    R, rhs, rest
        As above.
    rows
        Of M.
    squared
        Whether R comes from MᵀM, so that its columns are off by the square of M's condition, times rounding.

    """

    R: FloatArray
    rhs: FloatArray
    rest: float
    rows: int
    squared: bool

    @property
    def columns(self) -> int:
        """Return m."""
        return len(self.rhs)

    @classmethod
    def empty(cls) -> Self:
        """Return the triangle of no columns."""
        return cls(np.zeros((0, 0)), np.zeros(0), 0.0, 0, squared=False)

    @classmethod
    def of_normal_equations(cls, G: FloatArray, g: FloatArray, b: float, rows: int) -> Self:
        """Return the triangle of MᵀM (m, m), Mᵀb (m,) and bᵀb, of as many of the first columns as can be factored.

        Cholesky's method on the matrix with columns scaled to length 1 breaks down where 1/κ² falls below rounding.
        """
        size = np.sqrt(np.maximum(np.diag(G), np.finfo(float).tiny))
        R, failed = lapack.dpotrf(G / size / size[:, None], clean=1)
        m = failed - 1 if failed else len(g)
        R = R[:m, :m]
        rhs = solve_triangular(R, g[:m] / size[:m], trans="T", check_finite=False)
        rest = max(b - float(rhs @ rhs), 0.0) ** 0.5
        return cls(R * size[:m], rhs, rest, rows, squared=True)

    @classmethod
    def of_rows(cls, columns: int, chunks: Iterable[tuple[FloatArray, FloatArray]]) -> Self:
        """Return the triangle of rows that come as chunks of M (r, m), Fortran order, and b (r,); M is overwritten.

        Each chunk is factored together with the triangle of those before it (sequential TSQR; Demmel, Grigori, Hoemmen
        and Langou 2012), backward stable in any order.

        >>> M, b = np.array([[3.0], [4.0]]), np.array([5.0, 0.0])
        >>> t = RFactor.of_rows(1, [(M[:1], b[:1]), (M[1:], b[1:])])
        >>> round(float(t.rhs[0] / t.R[0, 0]), 12), round(t.rest, 12)               # 15/25, and 5 · 4/5
        (0.6, 4.0)
        """
        A, B, rest, rows = np.zeros((columns, columns), order="F"), np.zeros((columns, 1), order="F"), 0.0, 0
        for M, b in chunks:
            A, B, below = _stacked(A, B, M, b)
            rest, rows = float(np.hypot(rest, np.linalg.norm(below))), rows + len(b)
        return cls(np.triu(A), B[:, 0], rest, rows, squared=False)

    def joined(self, other: "RFactor") -> "RFactor":
        """Return the triangle of both systems' rows."""
        lower = np.array(other.R, order="F")
        A, B, below = _stacked(np.array(self.R, order="F"), self.rhs[:, None].copy(order="F"), lower, other.rhs)
        rest = float(np.linalg.norm(np.append(below, [self.rest, other.rest])))
        return RFactor(np.triu(A), B[:, 0], rest, self.rows + other.rows, self.squared or other.squared)


def _stacked(A: FloatArray, B: FloatArray, M: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Factor A above M; return the triangle, its right-hand side (m, 1), and what is left of b."""
    block = min(BLOCK, len(A))
    A, V, T, _ = lapack.dtpqrt(0, block, A, np.asfortranarray(M), overwrite_a=1, overwrite_b=1)
    B, below, _ = lapack.dtpmqrt(0, V, T, B, np.asfortranarray(b[:, None]), side="L", trans="T")
    return A, B, below
