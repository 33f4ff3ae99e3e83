r"""Gram–Schmidt orthogonalisation as the paper prints it, eq. (5): column by column, in one pass.

    r_{j,i+1} = q_jᵀ c_{i+1}  (j ≤ i),    q_{i+1} = c_{i+1} − Σ_j r_{j,i+1} q_j,    r_{i+1,i+1} = ‖q_{i+1}‖

then q_{i+1} is divided by r_{i+1,i+1}, and b̃_{i+1} = q_{i+1}ᵀ b. One pass loses orthogonality with the square of the
condition number: ‖QᵀQ − I‖ is 1e-7 at degree 10 of an outline and over 1 at degree 14, where the solution of R a = b̃ is
no longer that of least squares. The paper assumes that "the effect of rounding errors" is small (7.1);
`orthogonality_loss` measures it. Use this to repeat the paper, and the block factorisation for everything else.
"""

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.linear.qr.factorisation import Factorisation
from ipcore.options.choices import Collinear


class GramSchmidt(Factorisation):
    """M = QR by eq. (5), one column after another."""

    def append(self, columns: FloatArray, damping: FloatArray | None = None) -> BoolArray:
        """Append columns C (rows, k) with their κ d (k,), one by one; return whether each was kept, (k,)."""
        weights = np.zeros(columns.shape[1]) if damping is None else damping
        kept = np.array([self._append_one(c, w) for c, w in zip(columns.T, weights, strict=True)], dtype=np.bool_)
        self.kept = np.concatenate([self.kept, kept])
        return kept

    def orthogonality_loss(self, count: int) -> float:
        """Return ‖QᵀQ − I‖₂ of the first `count` columns, those of the ridge included."""
        Q = np.hstack([np.zeros((len(self._b), 0)), *self._Q.blocks()])[:, :count]
        return float(np.linalg.norm(Q.T @ Q - np.eye(count), 2)) if count else 0.0

    def _append_one(self, column: FloatArray, weight: float) -> bool:
        """Append one column (rows,) with its κ d; return whether it was kept."""
        c = np.zeros(len(self._b))
        c[: self._rows] = column
        blocks = self._Q.blocks()
        r = np.concatenate([np.zeros(0), *(Q.T @ c for Q in blocks)])
        q, row = c, 0
        for Q in blocks:
            q = q - Q @ r[row : row + Q.shape[1]]
            row += Q.shape[1]
        size, policy = float(np.linalg.norm(q)), self._policy
        collinear = size <= (0.0 if policy.collinear is Collinear.KEEP else policy.tolerance) * np.linalg.norm(column)
        if collinear and policy.collinear is not Collinear.RIDGE:
            return False
        if policy.full or collinear:
            self._damp(q[:, None], np.array([weight]), np.array([True]))
            size = float(np.linalg.norm(q))
        self._append_factor((q / size)[:, None], r[:, None], np.array([[size]]))
        return True

    def _project_rhs(self, Q: FloatArray, done: int) -> None:
        """Compute b̃ = Qᵀb from b itself, as printed, and not from the residual."""
        last = Q.T @ self._b
        self._residual -= Q @ last
        self._rhs[done : done + Q.shape[1]] = last
