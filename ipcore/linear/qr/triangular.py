"""The factorisation of a matrix that is triangular already: R is M, until something has to be done about a column."""

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt, independent


class Triangular(BlockGramSchmidt):
    """M = QR of an upper triangular M, with Q = I until the first column is left out or damped."""

    def append(self, columns: FloatArray, damping: FloatArray | None = None) -> BoolArray:
        """Append columns C (rows, k) with their κ d (k,), and return which of them were kept, (k,)."""
        start, new = len(self.kept), columns.shape[1]
        corner, kept = columns[start : start + new], np.ones(new, dtype=np.bool_)
        smallest = self._policy.tolerance * np.linalg.norm(columns, axis=0)
        if damping is not None or not self.kept.all() or not independent(corner, smallest).all():
            return super().append(columns, damping)
        Q = np.zeros((len(self._b), new))
        Q[start + np.arange(new), np.arange(new)] = 1.0
        self._grow(Q, columns[:start], corner)
        self.kept = np.concatenate([self.kept, kept])
        return kept
