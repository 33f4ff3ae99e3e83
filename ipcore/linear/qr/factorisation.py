r"""The base of all factorisations M = QR of a growing matrix: new columns change nothing of earlier ones (Fig. 2).

Ridge regression adds rows below M: for every damped column one row that is √(κ d_k) in that column and 0 elsewhere.
The least-squares solution with these rows is that of (MᵀM + κD) a = Mᵀb, which is the paper's eq. (8) for M = QR. The
row is 0 in all earlier columns, so appending it with its column turns r_kk into √(r_kk² + κ d_k) and changes nothing
else.
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
    """Which columns are left out, and which are damped.

    Attributes
    ----------
    tolerance
        Column c_i is collinear when |r_ii| ≤ tolerance · ‖c_i‖, with r_ii before any damping of this column.
    collinear
        Whether such columns are dropped, damped, or kept. A column with r_ii = 0 is dropped even if they are kept.
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
        (m,), whether each of the m columns appended so far was kept.
    ridged
        How many of the kept columns are damped.

    """

    def __init__(self, b: FloatArray, policy: Policy, damped: int = 0) -> None:
        """Start without columns.

        Parameters
        ----------
        b
            (rows,), the right-hand side.
        policy
            Which columns are left out or damped.
        damped
            The highest number of columns that may be damped; each takes one more row.

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
        self._trace = 0.0

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
        """Return ‖M a − b‖² of the solution, from the residual as a vector, so that no digits cancel."""
        return float(self.residual @ self.residual)

    @property
    def residual(self) -> FloatArray:
        """Return b − M a (rows,), without the rows of the ridge."""
        return self._residual[: self._rows]

    @property
    def degrees_of_freedom(self) -> float:
        """Return the trace of the matrix that takes b to M a: k, or less if columns are damped."""
        return self._trace if self.ridged else float(self._Q.count)

    def q_blocks(self, start: int = 0) -> list[FloatArray]:
        """Return the columns of Q from `start` on in blocks (rows, …), without the rows of the ridge."""
        return [Q[: self._rows] for Q in self._Q.blocks(start)]

    def replace_rhs(self, b: FloatArray) -> None:
        """Take another right-hand side (rows,), and compute b̃ anew."""
        self._b[: self._rows] = b
        self._residual = self._b.copy()
        done = 0
        for Q in self._Q.blocks():
            self._project_rhs(Q, done)
            done += Q.shape[1]

    def solve(self, rhs: FloatArray | None = None) -> FloatArray:
        """Return a (m,), the solution of R a = b̃, or of R a = `rhs` (k,); a is 0 for columns that were left out."""
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

    def orthogonality_loss(self, count: int) -> float | None:  # noqa: ARG002 - for subclasses that lose it
        """Return ‖QᵀQ − I‖₂ of the first `count` columns; None for factorisations that keep it at rounding."""
        return None

    def _append_factor(self, Q: FloatArray, above: FloatArray, corner: FloatArray) -> None:
        """Append columns Q (rows, k) and the columns [above; corner] of R, and compute the entries of b̃."""
        k, new = self._Q.count, Q.shape[1]
        if k + new > len(self._rhs):
            self._reserve(max(k + new, 2 * k))
        self._R[:k, k : k + new] = above
        self._R[k : k + new, k : k + new] = corner
        self._Q.append(Q)
        self._project_rhs(Q, k)
        if len(self._b) > self._rows:
            self._trace += float((Q[: self._rows] ** 2).sum())

    def _reserve(self, size: int) -> None:
        """Make room for `size` columns in R and b̃."""
        R, rhs, k = self._R, self._rhs, self._Q.count
        self._R, self._rhs = np.zeros((size, size)), np.zeros(size)
        self._R[:k, :k], self._rhs[:k] = R[:k, :k], rhs[:k]

    def _project_rhs(self, Q: FloatArray, done: int) -> None:
        """Compute the entries of b̃ from `done` on, Qᵀ times the residual, and subtract this part from the residual."""
        last = Q.T @ self._residual
        self._residual -= Q @ last
        self._rhs[done : done + Q.shape[1]] = last

    def _damp(self, C: FloatArray, damping: FloatArray, which: BoolArray) -> None:
        """Write √(κ d) into the next free rows below the columns of C (rows, k) that `which` (k,) selects."""
        columns = np.flatnonzero(which)
        start = self._rows + self.ridged
        C[start + np.arange(len(columns)), columns] = np.sqrt(damping[columns])
        self.ridged += len(columns)
