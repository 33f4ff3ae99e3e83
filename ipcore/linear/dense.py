"""Linear fits from all rows and columns, each prefix reusing the factorisation of the one before (Fig. 2)."""

from abc import ABC, abstractmethod
from dataclasses import replace

import numpy as np

from ipcore._typing import FloatArray
from ipcore.linear import ridge
from ipcore.linear.design_matrix import System, working_basis
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Factorisation, Policy
from ipcore.linear.qr.gram_schmidt import GramSchmidt
from ipcore.options.choices import Criterion, Factor, Ridge
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial import graded
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.search.criteria import Leverage
from ipcore.search.fitter import Fitted


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
            stop = min(alpha, graded.form(d, graded.degree_of(d, start + 1)).stop)
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


class LeastSquaresFit(GrowingFit):
    """Minimises ‖M a − b‖², and κ aᵀDa with it if that is asked for."""

    def __init__(self, data: OrientedPoints, options: FitOptions, max_degree: int) -> None:
        """Tabulate the univariate functions at the constraints' positions, up to the last degree."""
        self._data, self._dimension = data, data.points.shape[1]
        self._rows = options.family.rows(data.points, data.normals, options.row_parameters)
        self._basis = working_basis(options)
        self._system = System(self._rows, self._basis, data.bounds, max_degree)
        self._damping = None
        if options.ridge is not Ridge.NONE:
            D = ridge.diagonal(options.ridge_matrix, data.points, max_degree)
            self._damping = options.ridge_strength * D
        self._factor = self._factorisation(options)
        groups = len(self._rows.groups)
        self._leverage = Leverage(groups, len(data.points)) if options.criterion is Criterion.LOO else None

    def raise_to(self, alpha: int) -> Fitted:
        """Append the columns that are still missing, a whole form at a time, and solve."""
        degree = graded.degree_of(self._dimension, alpha)
        self._append(self._factor, alpha)
        if self._rows.gradient_length is not None:
            self._factor.retarget(self._rows.b(degree))
        polynomial = self._data.polynomial(degree, self._factor.solve(), self._basis)
        return self._step(polynomial, len(self._factor.residual), self._factor.rss, self._left_out())

    def orthogonality_loss(self, columns: int) -> float | None:
        """Return ‖QᵀQ − I‖₂ of the first columns that were kept; None where it is rounding by construction."""
        return self._factor.orthogonality_loss(columns)

    def _factorisation(self, options: FitOptions) -> Factorisation:
        kind = GramSchmidt if options.factor is Factor.GRAM_SCHMIDT else BlockGramSchmidt
        policy = Policy(options.collinear_tol, options.on_collinear, options.ridge is Ridge.FULL)
        return kind(self._rows.b(1), policy, 0 if self._damping is None else len(self._damping))

    def _columns(self, start: int, stop: int) -> FloatArray:
        return self._system.columns(start, stop)

    def _left_out(self) -> float | None:
        if self._leverage is None:
            return None
        self._leverage.add(self._factor.data_blocks(self._leverage.columns))
        return self._leverage.left_out(self._factor.residual)


class TaubinFit(LeastSquaresFit):
    r"""Minimises Σ f² / Σ ‖∇f‖² with the same growing factorisation.

    With [A; G] = QR, A the rows of f and G those of ∇f, and y = R a, the quotient is ‖Q_A y‖² / (‖y‖² − ‖Q_A y‖²): y is
    the right singular vector of Q_A with the smallest singular value. No square of A or G is formed, so what vanishes
    on the data is found to rounding; what vanishes in both, as the square of such a polynomial, is a collinear column.
    """

    def raise_to(self, alpha: int) -> Fitted:
        """Append the columns that are still missing, and take the smallest singular vector.

        f is scaled to mean ‖∇f‖² = 1, so that it is about a distance, and grows along the normals.
        """
        self._append(self._factor, alpha)
        points, normals = self._data.points, self._data.normals
        y = _smallest_right_singular_vector([block[: len(points)] for block in self._factor.data_blocks()])
        degree = graded.degree_of(points.shape[1], alpha)
        polynomial = self._data.polynomial(degree, self._factor.solve(y), self._basis)
        f, gradient = polynomial.value_and_gradient(points)
        size = float(np.sqrt((gradient**2).sum(axis=1).mean())) or 1.0  # every column but the constant may be dropped
        size *= 1.0 if (gradient * normals).sum() >= 0.0 else -1.0
        scaled = replace(polynomial, coefficients=polynomial.coefficients / size)
        return self._step(scaled, len(points), float(((f / size) ** 2).sum()))


def _smallest_right_singular_vector(blocks: list[FloatArray]) -> FloatArray:
    """Return y (k,) of length 1 with the least ‖[blocks] y‖; blocks (N, …) of k columns in all."""
    if not blocks:
        return np.zeros(0)
    return np.asarray(np.linalg.svd(np.linalg.qr(np.hstack(blocks), mode="r"))[2][-1])
