"""The growing linear system M a = b: columns of M on demand, over whatever rows a constraint family yields."""

from itertools import groupby

import numpy as np

from ipcore._typing import FloatArray
from ipcore.constraints.rows import RowGroup, Rows
from ipcore.options.choices import Factor, Ridge
from ipcore.options.fit_options import FitOptions
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.box import Box
from ipcore.polynomial.univariate import Basis


def working_basis(options: FitOptions) -> Basis:
    """Return the basis in which a fit is computed.

    Chebyshev products, which stay within ±1 all over the box; but the paper's eq. (5) speaks of the columns of
    monomials, and D of their coefficients (see `ridge`). Both bases are graded, so the first α columns span the same
    space in either.
    """
    plain = options.factor is not Factor.GRAM_SCHMIDT and options.ridge is Ridge.NONE
    return Basis.CHEBYSHEV if plain else Basis.MONOMIAL


class System:
    """The columns of M, in graded order.

    Univariate functions are tabulated once, up to the highest degree; a column is a product of their values.
    """

    def __init__(self, rows: Rows, kind: Basis, bounds: FloatArray, max_degree: int) -> None:
        """Tabulate the univariate functions, and their derivatives where a row asks for one.

        Parameters
        ----------
        rows
            What the constraint family yields.
        kind
            The basis; Chebyshev polynomials on the bounds, or powers in the normalised frame.
        bounds
            (2, d), in the normalised frame.
        max_degree
            The highest degree that will be asked for.

        """
        self._powers = graded.exponents(bounds.shape[1], max_degree)
        self._kind, self._degree = kind, max_degree
        d = bounds.shape[1]
        self._box = Box.of(bounds) if kind is Basis.CHEBYSHEV else Box(np.zeros(d), np.ones(d))
        self._tables = [
            self._tabulate(list(groups), key) for key, groups in groupby(rows.groups, lambda g: (g.axis, g.weight))
        ]

    def columns(self, start: int, stop: int) -> FloatArray:
        """Return columns `start` … `stop` − 1 of M, counted from 0, (rows, stop − start)."""
        powers = self._powers[start:stop]
        parts = [graded.products(tables, powers) for tables in self._tables]
        return (parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)).T

    def _tabulate(self, groups: list[RowGroup], functional: tuple[int | None, float]) -> list[FloatArray]:
        """Return one table (n+1, rows) per variable, whose products are the rows of these like groups."""
        axis, weight = functional
        positions = np.concatenate([group.positions for group in groups])
        t = self._box.to_cube(positions).T
        tables = [univariate.table(self._kind, np.ascontiguousarray(row), self._degree) for row in t]
        if axis is not None:
            derivative = univariate.differentiation(self._kind, self._degree).T / self._box.half[axis]
            tables[axis] = derivative @ tables[axis]
        if weight != 1.0:
            tables[0] = weight * tables[0]
        return tables
