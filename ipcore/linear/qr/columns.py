"""Storage for the columns of Q: a few wide blocks, so that products with all columns run at BLAS-3 speed."""

import numpy as np

from ipcore._typing import FloatArray

# Columns that are appended one by one are collected in blocks of this width: a product with 64 columns runs at full
# speed, and the memory of 63 columns at most is unused.
BLOCK_WIDTH = 64


class Columns:
    """A matrix (rows, k) to which columns are appended; `count` is k."""

    def __init__(self, rows: int) -> None:
        """Start without columns."""
        self.count = 0
        self._rows = rows
        self._blocks: list[FloatArray] = []
        self._filled: list[int] = []

    def append(self, Q: FloatArray) -> None:
        """Append columns (rows, k)."""
        new = Q.shape[1]
        if not self._blocks or self._filled[-1] + new > self._blocks[-1].shape[1]:
            self._blocks.append(np.empty((self._rows, max(new, BLOCK_WIDTH)), order="F"))
            self._filled.append(0)
        at = self._filled[-1]
        self._blocks[-1][:, at : at + new] = Q
        self._filled[-1] += new
        self.count += new

    def blocks(self, start: int = 0) -> list[FloatArray]:
        """Return the columns from `start` on, in order, as views (rows, …) with at least one column each."""
        views, passed = [], 0
        for block, filled in zip(self._blocks, self._filled, strict=True):
            if passed + filled > start:
                views.append(block[:, max(start - passed, 0) : filled])
            passed += filled
        return views
