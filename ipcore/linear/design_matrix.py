"""The design matrix M of a linear fit, column by column, for the rows of any constraint family."""

from itertools import groupby

import numpy as np

from ipcore._typing import FloatArray
from ipcore.constraints.rows import RowGroup, Rows
from ipcore.options.choices import Factor, Ridge
from ipcore.options.fit_options import FitOptions
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.univariate import Basis


def working_basis(options: FitOptions) -> Basis:
    """Return the basis in which a fit that holds M is computed.

    Chebyshev products, which stay within ±1 all over the box. But monomials for the paper's eq. (5), which is about
    their columns, and for a ridge, whose D is about their coefficients (see `ridge`). Both bases are graded, so the
    first α columns span the same space in either.
    """
    chebyshev = options.factor is not Factor.GRAM_SCHMIDT and options.ridge is Ridge.NONE
    return Basis.CHEBYSHEV if chebyshev else Basis.MONOMIAL


class DesignMatrix:
    """M: one row per row of the family, one column per function of the basis, in graded order.

    The univariate functions are tabulated once, up to the highest degree; a column is a product of their values.
    """

    def __init__(self, rows: Rows, basis: Basis, bounds: FloatArray, max_degree: int) -> None:
        """Tabulate the univariate functions, and their derivatives for the rows of derivatives.

        Parameters
        ----------
        rows
            The rows of the constraint family.
        basis
            Chebyshev products on the bounds, or monomials of the normalised frame.
        bounds
            (2, d), in the normalised frame.
        max_degree
            The degree of the last column.

        """
        self._powers = graded.exponents(bounds.shape[1], max_degree)
        self._basis, self._degree = basis, max_degree
        self._middle, self._half = np.zeros(bounds.shape[1]), np.ones(bounds.shape[1])
        if basis is Basis.CHEBYSHEV:
            self._middle, self._half = bounds.mean(axis=0), (bounds[1] - bounds[0]) / 2.0
        self._tables = [
            self._tabulate(list(groups), key) for key, groups in groupby(rows.groups, lambda g: (g.axis, g.weight))
        ]

    def columns(self, start: int, stop: int) -> FloatArray:
        """Return columns `start` … `stop` − 1 of M, counted from 0, (rows, stop − start)."""
        powers = self._powers[start:stop]
        parts = [graded.products(tables, powers) for tables in self._tables]
        return (parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)).T

    def _tabulate(self, groups: list[RowGroup], axis_and_weight: tuple[int | None, float]) -> list[FloatArray]:
        """Return one table (n+1, rows) per variable; products of their rows are the columns of M in these groups.

        All groups have the same axis and weight.
        """
        axis, weight = axis_and_weight
        positions = np.concatenate([group.positions for group in groups])
        t = ((positions - self._middle) / self._half).T
        tables = [univariate.table(self._basis, np.ascontiguousarray(row), self._degree) for row in t]
        if axis is not None:
            derivative = univariate.differentiation(self._basis, self._degree).T / self._half[axis]
            tables[axis] = derivative @ tables[axis]
        if weight != 1.0:
            tables[0] = weight * tables[0]
        return tables
