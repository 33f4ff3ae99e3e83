r"""Block Gram–Schmidt, done twice: the reference factorisation.

A whole form of columns C is made orthogonal to the columns before it, twice, and factored within:

    C = Q S₁ + Q₁R₁,    Q₁ = Q S₂ + Q₂R₂    ⇒    C = Q (S₁ + S₂R₁) + Q₂ (R₂R₁)

One pass loses orthogonality with the square of the condition number, as the paper's eq. (5) does column by column; the
second pass restores ‖QᵀQ − I‖ to rounding ("twice is enough", Giraud, Langou and Rozložník 2005). Q is kept: memory is
rows × columns.
"""

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ipcore._typing import BoolArray, FloatArray


class BlockGramSchmidt:
    """The factorisation of a growing matrix, and the least-squares solution with each of its prefixes.

    Attributes
    ----------
    R
        (k, k), upper triangular: the factor of the k columns that were kept.
    rhs
        (k,), b̃ = Qᵀb.
    kept
        (m,), which of the m columns appended so far were kept.

    """

    def __init__(self, b: FloatArray, tolerance: float) -> None:
        """Start without columns.

        Parameters
        ----------
        b
            (rows,), the right-hand side.
        tolerance
            Column i is collinear, and left out, when |r_ii| ≤ tolerance · ‖c_i‖.

        """
        self.R: FloatArray = np.zeros((0, 0))
        self.rhs: FloatArray = np.zeros(0)
        self.kept: BoolArray = np.zeros(0, dtype=np.bool_)
        self._tolerance = tolerance
        self._blocks: list[FloatArray] = []
        self._residual = b.copy()

    @property
    def rss(self) -> float:
        """Return the residual sum of squares ‖M a − b‖² of the solution, kept as a vector so that no digits cancel."""
        return float(self._residual @ self._residual)

    def append(self, columns: FloatArray) -> BoolArray:
        """Append columns C (rows, k), and return which of them were kept, (k,)."""
        sizes = np.linalg.norm(columns, axis=0)
        S, W = self._project(columns)
        Q1, R1 = np.linalg.qr(W)
        kept = _independent(R1, self._tolerance * sizes)
        if not kept.all():
            S = S[:, kept]
            Q1, R1 = np.linalg.qr(W[:, kept])
        if kept.any():
            S2, W = self._project(Q1)
            Q2, R2 = np.linalg.qr(W)
            self._grow(Q2, S + S2 @ R1, R2 @ R1)
        self.kept = np.concatenate([self.kept, kept])
        return kept

    def solve(self) -> FloatArray:
        """Return a (m,), the least-squares solution of M a = b, zero for columns that were left out."""
        a = np.zeros(len(self.kept))
        if len(self.rhs):
            a[self.kept] = solve_triangular(self.R, self.rhs, check_finite=False)
        return a

    def condition(self) -> float:
        """Return an estimate of κ₁ of R with its columns scaled to length 1 (LAPACK's trcon), good to a factor of 3."""
        if not len(self.R):
            return 1.0
        rcond, _ = lapack.dtrcon(self.R / np.linalg.norm(self.R, axis=0))
        return float(1.0 / rcond) if rcond > 0.0 else float("inf")

    def _project(self, C: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return S = QᵀC and C − QS."""
        if not self._blocks:
            return np.zeros((0, C.shape[1])), C
        S = np.vstack([Q.T @ C for Q in self._blocks])
        W, row = np.array(C, order="F"), 0
        for Q in self._blocks:
            W -= Q @ S[row : row + Q.shape[1]]
            row += Q.shape[1]
        return S, W

    def _grow(self, Q: FloatArray, above: FloatArray, corner: FloatArray) -> None:
        """Add the columns Q, the last columns of R and the last entries of b̃."""
        self.R = np.block([[self.R, above], [np.zeros((Q.shape[1], len(self.R))), corner]])
        last = Q.T @ self._residual
        self._residual -= Q @ last
        self.rhs = np.concatenate([self.rhs, last])
        self._blocks.append(Q)


def _independent(R: FloatArray, smallest: FloatArray) -> BoolArray:
    """Return which columns of a triangular factor (k, k) to keep, leaving out one by one those with |r_ii| too small.

    Whatever the direction of a left-out column's rounding noise was, the columns after it get it back before they are
    judged, which is why R is factored again each time.
    """
    kept = np.ones(R.shape[1], dtype=np.bool_)
    while kept.any():
        diagonal = np.abs(np.diag(R[: np.count_nonzero(kept)]))
        small = np.flatnonzero(diagonal <= smallest[kept])
        if not len(small):
            break
        kept[np.flatnonzero(kept)[small[0]]] = False
        _, R = np.linalg.qr(np.delete(R, small[0], axis=1))
    return kept
