"""Linear least squares with all rows and columns of M, and Q, in memory."""

from ipcore._typing import FloatArray
from ipcore.linear import ridge
from ipcore.linear.design_matrix import DesignMatrix, working_basis
from ipcore.linear.incremental import IncrementalFit
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Factorisation, Policy
from ipcore.linear.qr.gram_schmidt import GramSchmidt
from ipcore.options.choices import Factor, Ridge
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial import graded
from ipcore.search.fitter import PrefixFit
from ipcore.search.leverage import Leverage


class DenseFit(IncrementalFit):
    """Minimises ‖M a − b‖² + κ aᵀDa, the second term if the options ask for a ridge."""

    def __init__(self, data: OrientedPoints, options: FitOptions, max_degree: int) -> None:
        """Tabulate the univariate functions at the positions of the family's rows, up to the last degree."""
        self._data, self._dimension = data, data.points.shape[1]
        self._rows = options.family.rows(data.points, data.normals, options.row_parameters)
        self._basis = working_basis(options)
        self._matrix = DesignMatrix(self._rows, self._basis, data.bounds, max_degree)
        self._damping = None
        if options.ridge is not Ridge.NONE:
            D = ridge.diagonal(options.ridge_matrix, data.points, max_degree)
            self._damping = options.ridge_strength * D
        self._factor = self._factorisation(options)
        groups = len(self._rows.groups)
        self._leverage = Leverage(groups, len(data.points)) if options.criterion.needs_rows else None

    def raise_to(self, alpha: int) -> PrefixFit:
        """Append the columns up to the first α that are still missing, and solve."""
        degree = graded.degree_of(self._dimension, alpha)
        self._append(self._factor, alpha)
        if self._rows.gradient_length is not None:
            self._factor.replace_rhs(self._rows.b(degree))
        polynomial = self._data.polynomial(degree, self._factor.solve(), self._basis)
        return self._prefix_fit(polynomial, len(self._factor.residual), self._factor.rss, self._leave_one_out_error())

    def orthogonality_loss(self, columns: int) -> float | None:
        """Return ‖QᵀQ − I‖₂ of the first columns that were kept; None for factorisations that keep it at rounding."""
        return self._factor.orthogonality_loss(columns)

    def _factorisation(self, options: FitOptions) -> Factorisation:
        method = GramSchmidt if options.factor is Factor.GRAM_SCHMIDT else BlockGramSchmidt
        policy = Policy(options.collinear_tol, options.on_collinear, options.ridge is Ridge.FULL)
        return method(self._rows.b(1), policy, 0 if self._damping is None else len(self._damping))

    def _columns(self, start: int, stop: int) -> FloatArray:
        return self._matrix.columns(start, stop)

    def _leave_one_out_error(self) -> float | None:
        if self._leverage is None:
            return None
        self._leverage.add(self._factor.q_blocks(self._leverage.columns))
        return self._leverage.leave_one_out_error(self._factor.residual)
