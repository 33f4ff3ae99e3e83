"""What all linear fits share: columns are appended form by form, and each prefix reuses the factorisation (Fig. 2)."""

from abc import ABC, abstractmethod

import numpy as np

from ipcore._typing import FloatArray
from ipcore.linear.qr.factorisation import Factorisation
from ipcore.polynomial import graded
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.search.fitter import PrefixFit


class IncrementalFit(ABC):
    """Appends the columns of M to a factorisation form by form. A subclass provides the columns.

    A subclass sets `_factor`, the factorisation, `_damping`, κ D (m,) or None without a ridge, and `_dimension`.
    """

    _factor: Factorisation
    _damping: FloatArray | None
    _dimension: int

    @abstractmethod
    def _columns(self, start: int, stop: int) -> FloatArray:
        """Return columns `start` … `stop` − 1 of M, counted from 0, (rows, stop − start)."""

    def _append(self, factor: Factorisation, alpha: int) -> None:
        """Append the columns that `factor` does not have yet, up to the first α.

        One form at a time, so that the blocks, and the rounding with them, are the same whether degrees are fitted one
        by one or only the last.
        """
        start, d = len(factor.kept), self._dimension
        while start < alpha:
            stop = min(alpha, graded.form(d, graded.degree_of(d, start + 1)).stop)
            damping = None if self._damping is None else self._damping[start:stop]
            factor.append(self._columns(start, stop), damping)
            start = stop

    def _prefix_fit(self, polynomial: ImplicitPolynomial, rows: int, rss: float, loo: float | None = None) -> PrefixFit:
        """Return the polynomial with the figures of the factorisation as it stands."""
        factor, columns = self._factor, int(np.count_nonzero(self._factor.kept))
        return PrefixFit(
            polynomial,
            rows=rows,
            columns=columns,
            dropped=len(factor.kept) - columns,
            ridged=factor.ridged,
            degrees_of_freedom=factor.degrees_of_freedom,
            rss=rss,
            condition=factor.condition(),
            diagonal_ratio=factor.diagonal_ratio(),
            loo=loo,
        )
