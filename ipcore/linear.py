"""The linear fit at one degree after another: constraints in, Chebyshev coefficients out."""

from dataclasses import dataclass

import numpy as np

from ipcore import basis, monomials
from ipcore._typing import FloatArray
from ipcore.basis import Basis
from ipcore.constraints import three_layer
from ipcore.factor.block import BlockGramSchmidt
from ipcore.options import FitOptions
from ipcore.oriented import OrientedPoints


@dataclass(frozen=True, eq=False)
class LinearStep:
    """The solution at one degree.

    Attributes
    ----------
    coefficients
        (m,), of Chebyshev products on the data's bounds; 0 where a column was dropped.
    rows, columns, dropped
        The system's size: equations, coefficients in use, coefficients left out.
    rss
        Residual sum of squares.
    condition
        Estimated condition of R with columns scaled to length 1.

    """

    coefficients: FloatArray
    rows: int
    columns: int
    dropped: int
    rss: float
    condition: float

    @property
    def gcv(self) -> float:
        """Return generalised cross-validation, n·RSS/(n − k)²; infinite where it interpolates."""
        free = self.rows - self.columns
        return self.rows * self.rss / free**2 if free > 0 else float("inf")


class LinearFit:
    """Fits of degree 1, 2, …, each reusing the factorisation of the one before (the paper's Fig. 2)."""

    def __init__(self, data: OrientedPoints, options: FitOptions, max_degree: int) -> None:
        """Tabulate the univariate functions at the constraints' positions, up to the last degree."""
        positions, b = three_layer.layers(data.points, data.normals, options.layer_distance)
        middle, half = data.bounds.mean(axis=0), (data.bounds[1] - data.bounds[0]) / 2.0
        t = ((positions - middle) / half).T
        self._tables = [basis.table(Basis.CHEBYSHEV, np.ascontiguousarray(row), max_degree) for row in t]
        self._factor = BlockGramSchmidt(b, options.collinear_tol)
        self._rows = len(b)
        self._append(0)

    def raise_to(self, degree: int) -> LinearStep:
        """Append the form of this degree, one above the last, and solve."""
        self._append(degree)
        kept = self._factor.kept
        columns = int(np.count_nonzero(kept))
        return LinearStep(
            self._factor.solve(),
            self._rows,
            columns,
            len(kept) - columns,
            self._factor.rss,
            self._factor.condition(),
        )

    def _append(self, degree: int) -> None:
        d = len(self._tables)
        powers = monomials.exponents(d, degree)[monomials.form(d, degree)]
        self._factor.append(monomials.products(self._tables, powers).T)
