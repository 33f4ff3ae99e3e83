r"""Block Gram–Schmidt, done twice: the reference factorisation.

A whole form of columns C is made orthogonal to the columns before it, twice, and factored within:

    C = Q S₁ + Q₁R₁,    Q₁ = Q S₂ + Q₂R₂    ⇒    C = Q (S₁ + S₂R₁) + Q₂ (R₂R₁)

One pass loses orthogonality with the square of the condition number, as the paper's eq. (5) does column by column; the
second pass restores ‖QᵀQ − I‖ to rounding ("twice is enough", Giraud, Langou and Rozložník 2005). Q is kept: memory is
rows × columns.
"""

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.linear.qr.factorisation import Factorisation
from ipcore.options.choices import Collinear


class BlockGramSchmidt(Factorisation):
    """M = QR by blocks of columns, with Q orthonormal to rounding whatever the condition of M."""

    def append(self, columns: FloatArray, damping: FloatArray | None = None) -> BoolArray:
        """Append columns C (rows, k) with their κ d (k,); return whether each was kept, (k,)."""
        C = self._padded(columns)
        S, W = self._project(C)
        Q1, R1 = np.linalg.qr(W)
        kept, damped = self._classify(R1, np.linalg.norm(columns, axis=0))
        if damping is not None:
            self._damp(W, damping, damped)
        if damped.any() or not kept.all():
            S = S[:, kept]
            Q1, R1 = np.linalg.qr(W[:, kept])
        if kept.any():
            S2, W = self._project(Q1)
            Q2, R2 = np.linalg.qr(W)
            self._append_factor(Q2, S + S2 @ R1, R2 @ R1)
        self.kept = np.concatenate([self.kept, kept])
        return kept

    def _classify(self, R: FloatArray, sizes: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Return which columns to keep and which to damp, (k,) each, from their R (k, k) and lengths (k,)."""
        policy = self._policy
        new = independent_columns(R, (0.0 if policy.collinear is Collinear.KEEP else policy.tolerance) * sizes)
        kept = np.ones_like(new) if policy.collinear is Collinear.RIDGE else new
        damped = kept if policy.full else kept & ~new
        return kept, damped

    def _padded(self, C: FloatArray) -> FloatArray:
        """Return C (rows, k) with rows of zeros below it, one for each column that may be damped."""
        room = len(self._b) - self._rows
        return np.pad(C, ((0, room), (0, 0))) if room else C

    def _project(self, C: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return S = QᵀC and C − QS, with Q all columns so far."""
        blocks = self._Q.blocks()
        if not blocks:
            return np.zeros((0, C.shape[1])), C
        S = np.vstack([Q.T @ C for Q in blocks])
        W, row = np.array(C, order="F"), 0
        for Q in blocks:
            W -= Q @ S[row : row + Q.shape[1]]
            row += Q.shape[1]
        return S, W


def independent_columns(R: FloatArray, smallest: FloatArray) -> BoolArray:
    """Return which columns of a triangular factor R (k, k) are independent, (k,): those with |r_ii| > smallest (k,).

    Columns are left out one by one, from the left. The direction of a left-out column is rounding noise, but the later
    columns had their part along it taken out; R is factored again each time so that they get it back before they are
    compared.
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
