r"""R and b̃ of M = QR, without Q and without M in memory: all that least squares needs of a linear system.

    ‖M a − b‖² = ‖R a − b̃‖² + ρ²

for every a, so also for every prefix of the columns. R and b̃ are small: (m, m) and (m,), however many rows M has. They
are computed in one of two ways: as the Cholesky factor of MᵀM, which squares the condition of M, or from chunks of rows
that are factored one below the other.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ipcore._typing import FloatArray

LAPACK_BLOCK = 32  # columns in LAPACK's inner block: of 16, 32 and 64 the fastest for 90 to 1,000 columns


@dataclass(frozen=True, eq=False)
class RFactor:
    """R, b̃ and ρ of a linear system.

    Attributes
    ----------
    R
        (m, m), upper triangular.
    rhs
        (m,), b̃.
    residual_norm
        ρ, the norm of the residual when all m columns are used.
    rows
        The number of rows of M.
    from_gram
        Whether R is the Cholesky factor of MᵀM. Its relative error is then the square of M's condition times rounding.

    """

    R: FloatArray
    rhs: FloatArray
    residual_norm: float
    rows: int
    from_gram: bool

    @property
    def columns(self) -> int:
        """Return m."""
        return len(self.rhs)

    @classmethod
    def empty(cls) -> Self:
        """Return the factor of a system without columns."""
        return cls(np.zeros((0, 0)), np.zeros(0), 0.0, 0, from_gram=False)

    @classmethod
    def of_normal_equations(cls, G: FloatArray, g: FloatArray, bb: float, rows: int) -> Self:
        """Return the factor from G = MᵀM (m, m), g = Mᵀb (m,) and bᵀb, for as many first columns as can be factored.

        M's columns are scaled to length 1. Cholesky's method then fails at the column where 1/κ² falls below rounding.
        """
        size = np.sqrt(np.maximum(np.diag(G), np.finfo(float).tiny))
        R, failed = lapack.dpotrf(G / size / size[:, None], clean=1)
        m = failed - 1 if failed else len(g)
        R = R[:m, :m]
        rhs = solve_triangular(R, g[:m] / size[:m], trans="T", check_finite=False)
        residual_norm = max(bb - float(rhs @ rhs), 0.0) ** 0.5
        return cls(R * size[:m], rhs, residual_norm, rows, from_gram=True)

    @classmethod
    def of_rows(cls, columns: int, chunks: Iterable[tuple[FloatArray, FloatArray]]) -> Self:
        """Return the factor of rows that come in chunks: M (r, m), in Fortran order, and b (r,). M is overwritten.

        Each chunk is factored together with R of the chunks before it (sequential TSQR; Demmel, Grigori, Hoemmen and
        Langou 2012). It is backward stable, whatever the order of the chunks.

        >>> M, b = np.array([[3.0], [4.0]]), np.array([5.0, 0.0])
        >>> system = RFactor.of_rows(1, [(M[:1], b[:1]), (M[1:], b[1:])])
        >>> round(float(system.rhs[0] / system.R[0, 0]), 12), round(system.residual_norm, 12)    # 15/25, and 5 · 4/5
        (0.6, 4.0)
        """
        A, B = np.zeros((columns, columns), order="F"), np.zeros((columns, 1), order="F")
        residual_norm, rows = 0.0, 0
        for M, b in chunks:
            A, B, below = _stacked(A, B, M, b)
            residual_norm, rows = float(np.hypot(residual_norm, np.linalg.norm(below))), rows + len(b)
        return cls(np.triu(A), B[:, 0], residual_norm, rows, from_gram=False)

    def joined(self, other: "RFactor") -> "RFactor":
        """Return the factor of the rows of both systems."""
        lower = np.array(other.R, order="F")
        A, B, below = _stacked(np.array(self.R, order="F"), self.rhs[:, None].copy(order="F"), lower, other.rhs)
        residual_norm = float(np.linalg.norm(np.append(below, [self.residual_norm, other.residual_norm])))
        from_gram = self.from_gram or other.from_gram
        return RFactor(np.triu(A), B[:, 0], residual_norm, self.rows + other.rows, from_gram)


def _stacked(A: FloatArray, B: FloatArray, M: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Factor [A; M] for upper triangular A (m, m) and M (r, m), with right-hand sides B (m, 1) and b (r,).

    Return the new A and B, and the part of the right-hand side that is orthogonal to all columns, (r, 1).
    """
    block = min(LAPACK_BLOCK, len(A))
    A, V, T, _ = lapack.dtpqrt(0, block, A, np.asfortranarray(M), overwrite_a=1, overwrite_b=1)
    B, below, _ = lapack.dtpmqrt(0, V, T, B, np.asfortranarray(b[:, None]), side="L", trans="T")
    return A, B, below
