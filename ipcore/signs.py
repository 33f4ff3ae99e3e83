"""Which sign f must have, and by how much, at nodes of the box."""
from dataclasses import dataclass

import numpy as np

from ipcore import basis, contraction, gram
from ipcore._typing import FloatArray
from ipcore.basis import Basis


BEYOND = 1.02


def lobatto(count):
    return -BEYOND * np.cos(np.pi * np.arange(count) / (count - 1))


class SignNodes:
    """Chebyshev–Lobatto nodes of the box with side σ (0 where nothing is asked) and margin τ, (nodes, …) each."""

    def __init__(self, side, margin):
        self.side, self.margin = side, np.where(side == 0, 0.0, margin)
        self.d = side.ndim
        self.lines = [lobatto(c) for c in side.shape]
        self._tables = {}

    def tables(self, degree):
        if degree not in self._tables:
            self._tables[degree] = [basis.table(Basis.CHEBYSHEV, u, degree) for u in self.lines]
        return self._tables[degree]

    def values(self, tensor):
        return contraction.along_axes(tensor, [np.ascontiguousarray(t.T) for t in self.tables(tensor.shape[0] - 1)])

    def shortfall(self, values):
        return np.maximum(0.0, self.margin - self.side * values)

    def gram(self, shortfall, degree):
        """Return moments (C, 1) of the active set."""
        return gram.grid_moments((shortfall > 0).astype(float), self.tables(2 * degree)) / shortfall.size

    def pull(self, shortfall, degree):
        """Return Σ σ v P / M, the negative half gradient, tensor."""
        v = shortfall * self.side / shortfall.size
        for t in self.tables(degree):
            v = np.tensordot(v, t, axes=(0, 1))
        return v
