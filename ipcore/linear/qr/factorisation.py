r"""What every factorisation of a growing matrix M = QR offers; columns are appended, nothing earlier changes (Fig. 2).

Ridge regression is a matter of more rows: below M stands, for every damped column, one row that is √(κ d_k) in that
column and 0 elsewhere. Its least-squares solution is that of (MᵀM + κD) a = Mᵀb, which is the paper's eq. (8) for
M = QR. The row is 0 in all earlier columns, so appending it with its column turns r_kk into √(r_kk² + κ d_k) and moves
nothing else.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ipcore._typing import BoolArray, FloatArray
from ipcore.linear.qr.columns import Columns
from ipcore.options.choices import Collinear


@dataclass(frozen=True)
class Policy:
    """What is done about columns that are hard to tell apart.

    Attributes
    ----------
    tolerance
        Column i is collinear when |r_ii| ≤ tolerance · ‖c_i‖, r_ii taken before it is damped itself.
    collinear
        Drop such columns, damp them, or keep them; of a column that is kept something must be new.
    full
        Whether every column is damped.

    """

    tolerance: float
    collinear: Collinear = Collinear.DROP
    full: bool = False


class Factorisation(ABC):
    """The factorisation of a growing matrix, and the least-squares solution with each of its prefixes.

    Attributes
    ----------
    R
        (k, k), upper triangular: the factor of the k columns that were kept.
    rhs
        (k,), b̃ = Qᵀb.
    kept
        (m,), which of the m columns appended so far were kept.
    ridged
        How many of these are damped.

    """

    def __init__(self, b: FloatArray, policy: Policy, damped: int = 0) -> None:
        """Start without columns.

        Parameters
        ----------
        b
            (rows,), the right-hand side.
        policy
            What is done about collinear columns.
        damped
            How many columns may be damped at most, each of which takes one row more.

        """
        self.kept: BoolArray = np.zeros(0, dtype=np.bool_)
        self.ridged = 0
        self._policy = policy
        self._rows = len(b)
        self._b = np.concatenate([b, np.zeros(damped)])
        self._residual = self._b.copy()
        self._Q = Columns(len(self._b))
        self._R: FloatArray = np.zeros((0, 0))
        self._rhs: FloatArray = np.zeros(0)
        self._freedom = 0.0

    @abstractmethod
    def append(self, columns: FloatArray, damping: FloatArray | None = None) -> BoolArray:
        """Append columns C (rows, k) with their κ d (k,), and return which of them were kept, (k,)."""

    @property
    def R(self) -> FloatArray:  # noqa: N802 - matrices keep their letters
        """Return R (k, k)."""
        k = self._Q.count
        return self._R[:k, :k]

    @property
    def rhs(self) -> FloatArray:
        """Return b̃ (k,)."""
        return self._rhs[: self._Q.count]

    @property
    def rss(self) -> float:
        """Return the residual sum of squares ‖M a − b‖² of the solution, kept as a vector so that no digits cancel."""
        return float(self.residual @ self.residual)

    @property
    def residual(self) -> FloatArray:
        """Return b − M a (rows,), without the rows of the ridge."""
        return self._residual[: self._rows]

    @property
    def freedom(self) -> float:
        """Return the degrees of freedom, the trace of the matrix that takes b to M a: k, or less if damped."""
        return self._freedom if self.ridged else float(self._Q.count)

    def data_blocks(self, start: int = 0) -> list[FloatArray]:
        """Return the columns of Q from `start` on in blocks (rows, …), without the rows of the ridge."""
        return [Q[: self._rows] for Q in self._Q.blocks(start)]

    def retarget(self, b: FloatArray) -> None:
        """Take another right-hand side (rows,): b̃ is computed anew."""
        self._b[: self._rows] = b
        self._residual = self._b.copy()
        done = 0
        for Q in self._Q.blocks():
            self._explain(Q, done)
            done += Q.shape[1]

    def solve(self, rhs: FloatArray | None = None) -> FloatArray:
        """Return a (m,), the solution of R a = b̃ or of R a = `rhs`, zero for columns that were left out."""
        a = np.zeros(len(self.kept))
        if self._Q.count:
            a[self.kept] = solve_triangular(self.R, self.rhs if rhs is None else rhs, check_finite=False)
        return a

    def condition(self) -> float:
        """Return an estimate of κ₁ of R with its columns scaled to length 1 (LAPACK's trcon), good to a factor of 3."""
        if not self._Q.count:
            return 1.0
        rcond, _ = lapack.dtrcon(self.R / np.linalg.norm(self.R, axis=0))
        return float(1.0 / rcond) if rcond > 0.0 else float("inf")

    def diagonal_ratio(self) -> float:
        """Return max |r_ii| / min |r_ii|, the paper's measure of condition: a lower bound that depends on units."""
        diagonal = np.abs(np.diag(self.R))
        return float(diagonal.max() / diagonal.min()) if len(diagonal) else 1.0

    def orthogonality_loss(self, count: int) -> float | None:  # noqa: ARG002 - for those that lose it
        """Return ‖QᵀQ − I‖₂ of the first `count` columns; None where it is rounding by construction."""
        return None

    def _grow(self, Q: FloatArray, above: FloatArray, corner: FloatArray) -> None:
        """Add the columns Q, the last columns of R and the last entries of b̃."""
        k, new = self._Q.count, Q.shape[1]
        if k + new > len(self._rhs):
            self._reserve(max(k + new, 2 * k))
        self._R[:k, k : k + new] = above
        self._R[k : k + new, k : k + new] = corner
        self._Q.append(Q)
        self._explain(Q, k)
        if len(self._b) > self._rows:
            self._freedom += float((Q[: self._rows] ** 2).sum())

    def _reserve(self, size: int) -> None:
        R, rhs, k = self._R, self._rhs, self._Q.count
        self._R, self._rhs = np.zeros((size, size)), np.zeros(size)
        self._R[:k, :k], self._rhs[:k] = R[:k, :k], rhs[:k]

    def _explain(self, Q: FloatArray, done: int) -> None:
        """Take what the columns Q explain out of the residual, as the entries of b̃ from `done` on."""
        last = Q.T @ self._residual
        self._residual -= Q @ last
        self._rhs[done : done + Q.shape[1]] = last

    def _damp(self, C: FloatArray, damping: FloatArray, which: BoolArray) -> None:
        """Write √(κ d) into the next free rows of the columns `which`."""
        columns = np.flatnonzero(which)
        start = self._rows + self.ridged
        C[start + np.arange(len(columns)), columns] = np.sqrt(damping[columns])
        self.ridged += len(columns)
