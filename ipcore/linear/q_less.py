r"""Linear fits from the system's triangle, for which M is never held.

While the condition allows, the triangle comes from moments: R is the Cholesky factor of MᵀM, which squares the
condition κ. Once that would show in the answer, the answer is refined on the rows themselves, and once this no longer
settles, the triangle is made from the rows. `bench/PEERS.md` has the errors against a backward stable solve, by degree.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.linear import ridge
from ipcore.linear.dense import GrowingFit
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
from ipcore.search.fitter import Fitted

SMALL = 1 << 20  # entries of M up to which its triangle is made from the rows: 8 MB, and some milliseconds
FIRST, GROWTH = 6, 1.5  # the degree for which columns are made first, and by how much it grows when that is passed
# κ₁, as LAPACK estimates it, below which an answer is good as it is: over 26 sets D_dist was off by less than 6e-8 of
# itself on curves, and 3e-10 on surfaces.
GOOD = 1e5


class QLessFit(GrowingFit):
    """Minimises ‖M a − b‖², and κ aᵀDa with it if that is asked for, knowing M by its triangle alone."""

    def __init__(self, data: OrientedPoints, options: FitOptions, max_degree: int, source: RowSource) -> None:
        """Take the rows' source. Of the data, the polynomial's frame and bounds, and D of the ridge."""
        self._data, self._options, self._source = data, options, source
        self._dimension = d = data.points.shape[1]
        self._last = min(max_degree, graded.degree_of(d, max(data.count, d + 1)))  # no more columns than points
        self._damping = None
        if options.ridge is not Ridge.NONE:
            D = ridge.diagonal(options.ridge_matrix, data.points, self._last)
            self._damping = options.ridge_strength * data.count / len(data.points) * D
        rows = options.family.rows_per_point(d) * data.count
        small = rows * graded.count(d, self._last) <= SMALL and options.factor is Factor.AUTO
        squares = bool(options.layer_offsets) and options.factor is not Factor.TSQR
        self._squares = squares and not small
        self._refined: dict[int, Refinement]  # by the number of columns
        self._take(RFactor.empty())

    def raise_to(self, alpha: int) -> Fitted | None:
        """Solve for the first α columns; None if they cannot be told apart any more."""
        degree = graded.degree_of(self._dimension, alpha)
        if self._triangle.columns < alpha and not self._make(degree):
            return None
        self._append(self._factor, alpha)
        solved = self._solved(alpha)
        if solved is None:  # squaring the condition shows, for good
            self._squares = False
            self._take(RFactor.empty())
            return self.raise_to(alpha)
        a, rss = solved
        return self._step(self._data.polynomial(degree, a, Basis.MONOMIAL), self._triangle.rows, rss)

    def orthogonality_loss(self, columns: int) -> None:
        """Return None: it is rounding by construction."""

    def _columns(self, start: int, stop: int) -> FloatArray:
        """Return columns of R, with a row of zeros for ρ below."""
        return self._R[:, start:stop]

    def _make(self, degree: int) -> bool:
        """Make a triangle for this degree and some more, and start its factorisation; return whether there is one."""
        ahead = max(FIRST, int(np.ceil(GROWTH * degree)))
        reach = self._last if self._options.criterion is Criterion.NONE else min(ahead, self._last)
        triangle = self._source.squared(reach) if self._squares else None
        if triangle is None or triangle.columns < graded.count(self._dimension, degree):
            self._squares = False
            triangle = self._source.exact(reach)
        if triangle is not None:
            self._take(triangle)
        return triangle is not None

    def _take(self, triangle: RFactor) -> None:
        """Go on with this triangle."""
        self._triangle, self._refined = triangle, dict[int, Refinement]()
        self._R = np.vstack([triangle.R, np.zeros((1, triangle.columns))])
        self._factor = self._factorisation()

    def _factorisation(self) -> Triangular:
        options, t = self._options, self._triangle
        policy = Policy(options.collinear_tol, options.on_collinear, options.ridge is Ridge.FULL)
        b = np.append(t.rhs, t.rest)
        return Triangular(b, policy, 0 if self._damping is None else t.columns)

    def _solved(self, alpha: int) -> tuple[FloatArray, float] | None:
        """Return the solution (m,) and ‖M a − b‖², refined if need be; None if that is not enough."""
        factor = self._factor
        if not self._triangle.squared or factor.condition() < GOOD:
            return factor.solve(), factor.rss
        if alpha not in self._refined:
            self._refine(alpha)
        fit = self._refined.get(alpha)
        if fit is None or fit.settled is False:
            return None
        a = np.zeros(alpha)
        a[fit.used] = fit.a
        return a, fit.rss

    def _refine(self, alpha: int) -> None:
        """Refine this fit, and those of the degrees above it that the triangle has."""
        last = graded.degree_of(self._dimension, self._triangle.columns)
        first = graded.degree_of(self._dimension, alpha) + 1
        ahead = self._factorisation()
        for columns in (alpha, *(graded.count(self._dimension, n) for n in range(first, last + 1))):
            if columns > self._triangle.columns:
                break
            if columns in self._refined:
                continue
            self._append(ahead, columns)
            if ahead.condition() > self._source.worst or ahead.ridged:
                break
            used = np.flatnonzero(ahead.kept)
            self._refined[columns] = Refinement(ahead.R.copy(), used, ahead.solve()[used], ahead.rss)
        refine(list(self._refined.values()), self._source, last, graded.count(self._dimension, last))
