"""The factorisation of a matrix that is triangular already."""

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt, independent_columns


class Triangular(BlockGramSchmidt):
    """The factorisation M = QR of an upper triangular matrix M.

    As long as every column is kept and none is damped, Q is the identity and R is M, so that nothing is computed. After
    that, columns are orthogonalised as in any other matrix.
    """

    def append(self, columns: FloatArray, damping: FloatArray | None = None) -> BoolArray:
        """Append columns C (rows, k) with their κ d (k,); return whether each was kept, (k,)."""
        start, new = len(self.kept), columns.shape[1]
        corner, kept = columns[start : start + new], np.ones(new, dtype=np.bool_)
        smallest = self._policy.tolerance * np.linalg.norm(columns, axis=0)
        if damping is not None or not self.kept.all() or not independent_columns(corner, smallest).all():
            return super().append(columns, damping)
        Q = np.zeros((len(self._b), new))
        Q[start + np.arange(new), np.arange(new)] = 1.0
        self._append_factor(Q, columns[:start], corner)
        self.kept = np.concatenate([self.kept, kept])
        return kept
