"""What linear least-squares fits have in common: a factorisation that grows by columns, and what is reported of it."""

from abc import ABC, abstractmethod

import numpy as np

from ipcore import monomials
from ipcore._typing import FloatArray
from ipcore.factor.interface import Factorisation
from ipcore.polynomial import ImplicitPolynomial
from ipcore.prefix import Fitted


class GrowingFit(ABC):
    """Appends columns form by form, and tells what is known of each prefix. The columns come from a subclass."""

    _factor: Factorisation
    _damping: FloatArray | None  # κ D (m,), if there is a ridge
    _dimension: int

    @abstractmethod
    def _columns(self, start: int, stop: int) -> FloatArray:
        """Return columns `start` … `stop` − 1 of M, counted from 0."""

    def _append(self, factor: Factorisation, alpha: int) -> None:
        """Append form by form: the blocks are the same whether degrees are asked for one by one or at once."""
        start, d = len(factor.kept), self._dimension
        while start < alpha:
            stop = min(alpha, monomials.form(d, monomials.degree_of(d, start + 1)).stop)
            damping = None if self._damping is None else self._damping[start:stop]
            factor.append(self._columns(start, stop), damping)
            start = stop

    def _step(self, polynomial: ImplicitPolynomial, rows: int, rss: float, loo: float | None = None) -> Fitted:
        factor, columns = self._factor, int(np.count_nonzero(self._factor.kept))
        return Fitted(
            polynomial,
            rows,
            columns,
            len(factor.kept) - columns,
            factor.ridged,
            factor.freedom,
            rss,
            factor.condition(),
            factor.diagonal_ratio(),
            loo,
        )
