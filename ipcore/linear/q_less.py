r"""Linear fits from R and b̃ alone, without M or Q in memory.

While the condition allows, R comes from moments: it is the Cholesky factor of MᵀM, which squares the condition κ. Where
that would show in the solution, the solution is corrected by the rows. Where the corrections no longer converge, R is
computed from the rows. `bench/PEERS.md` has the errors against a backward stable solve, by degree.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.linear import ridge
from ipcore.linear.incremental import IncrementalFit
from ipcore.linear.qr.factorisation import Policy
from ipcore.linear.qr.r_factor import RFactor
from ipcore.linear.qr.triangular import Triangular
from ipcore.linear.row_source import RowSource
from ipcore.linear.seminormal import Refinement, refine
from ipcore.options.choices import Criterion, Factor, Ridge
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial import graded
from ipcore.polynomial.univariate import Basis
from ipcore.search.fitter import PrefixFit

# Entries of M up to which R is computed from the rows at once: 8 MB, and some milliseconds.
SMALL_SYSTEM_ENTRIES = 1 << 20
# The degree up to which R is computed first. When the search goes on to a degree that R does not have, R is computed up
# to this degree times the growth, so that there are few passes over the points.
FIRST_R_DEGREE, R_DEGREE_GROWTH = 6, 1.5
# κ₁ of R, as LAPACK estimates it, below which the solution from MᵀM needs no correction: over 26 sets D_dist was off by
# less than 6e-8 of itself on curves, and 3e-10 on surfaces.
MAX_UNCORRECTED_CONDITION = 1e5


class QLessFit(IncrementalFit):
    """Minimises ‖M a − b‖² + κ aᵀDa, the second term if the options ask for a ridge, from R and b̃ of M = QR."""

    def __init__(self, data: OrientedPoints, options: FitOptions, max_degree: int, source: RowSource) -> None:
        """Take the source of the rows. The data give the polynomial's frame and bounds, and D of the ridge."""
        self._data, self._options, self._source = data, options, source
        self._dimension = d = data.points.shape[1]
        self._last = min(max_degree, graded.degree_of(d, max(data.count, d + 1)))  # no more columns than points
        self._damping = None
        if options.ridge is not Ridge.NONE:
            D = ridge.diagonal(options.ridge_matrix, data.points, self._last)
            # D is a sum over the points that are held, MᵀM one over all of them
            self._damping = options.ridge_strength * data.count / len(data.points) * D
        entries = options.family.rows_per_point(d) * data.count * graded.count(d, self._last)
        small = entries <= SMALL_SYSTEM_ENTRIES and options.factor is Factor.AUTO
        summable = bool(options.layer_offsets) and options.factor is not Factor.TSQR
        self._from_moments = summable and not small
        self._refined: dict[int, Refinement]  # by the number of columns
        self._set_r_factor(RFactor.empty())

    def raise_to(self, alpha: int) -> PrefixFit | None:
        """Solve for the first α columns; None if there are no rows and their moments do not determine the solution."""
        degree = graded.degree_of(self._dimension, alpha)
        if self._r_factor.columns < alpha and not self._extend(degree):
            return None
        self._append(self._factor, alpha)
        solution = self._solve(alpha)
        if solution is None:  # from this degree on, R must come from the rows
            self._from_moments = False
            self._set_r_factor(RFactor.empty())
            return self.raise_to(alpha)
        a, rss = solution
        return self._prefix_fit(self._data.polynomial(degree, a, Basis.MONOMIAL), self._r_factor.rows, rss)

    def orthogonality_loss(self, columns: int) -> None:
        """Return None: there is no Q that could lose orthogonality."""

    def _columns(self, start: int, stop: int) -> FloatArray:
        """Return columns of R, with a row of zeros for ρ below."""
        return self._R[:, start:stop]

    def _extend(self, degree: int) -> bool:
        """Compute R for this degree and some more, and start its factorisation; return False if there are no rows."""
        ahead = max(FIRST_R_DEGREE, int(np.ceil(R_DEGREE_GROWTH * degree)))
        target = self._last if self._options.criterion is Criterion.NONE else min(ahead, self._last)
        r_factor = self._source.from_moments(target) if self._from_moments else None
        if r_factor is None or r_factor.columns < graded.count(self._dimension, degree):
            self._from_moments = False
            r_factor = self._source.from_rows(target)
        if r_factor is not None:
            self._set_r_factor(r_factor)
        return r_factor is not None

    def _set_r_factor(self, r_factor: RFactor) -> None:
        """Replace R and b̃, and start their factorisation."""
        self._r_factor, self._refined = r_factor, dict[int, Refinement]()
        self._R = np.vstack([r_factor.R, np.zeros((1, r_factor.columns))])
        self._factor = self._factorisation()

    def _factorisation(self) -> Triangular:
        """Return a factorisation of [R; 0], with the right-hand side [b̃; ρ], without columns."""
        options, r = self._options, self._r_factor
        policy = Policy(options.collinear_tol, options.on_collinear, options.ridge is Ridge.FULL)
        rhs = np.append(r.rhs, r.residual_norm)
        return Triangular(rhs, policy, 0 if self._damping is None else r.columns)

    def _solve(self, alpha: int) -> tuple[FloatArray, float] | None:
        """Return the solution (α,) and ‖M a − b‖², corrected if need be; None if the corrections do not converge."""
        factor = self._factor
        if not self._r_factor.from_gram or factor.condition() < MAX_UNCORRECTED_CONDITION:
            return factor.solve(), factor.rss
        if alpha not in self._refined:
            self._refine(alpha)
        fit = self._refined.get(alpha)
        if fit is None or fit.converged is False:
            return None
        a = np.zeros(alpha)
        a[fit.used] = fit.a
        return a, fit.rss

    def _refine(self, alpha: int) -> None:
        """Correct the fit with α columns, and those of the higher degrees that R has, in the same passes."""
        last = graded.degree_of(self._dimension, self._r_factor.columns)
        first = graded.degree_of(self._dimension, alpha) + 1
        factor = self._factorisation()
        for columns in (alpha, *(graded.count(self._dimension, n) for n in range(first, last + 1))):
            if columns > self._r_factor.columns:
                break
            if columns in self._refined:
                continue
            self._append(factor, columns)
            if factor.condition() > self._source.max_condition or factor.ridged:
                break
            used = np.flatnonzero(factor.kept)
            self._refined[columns] = Refinement(factor.R.copy(), used, factor.solve()[used], factor.rss)
        refine(list(self._refined.values()), self._source, last, graded.count(self._dimension, last))
