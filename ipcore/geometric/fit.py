"""The geometric fit under sign constraints, at one degree after another.

A degree starts from the fit of the degree below and follows the homotopy to the geometric objective (`continuation`).
The weight of the angles is then balanced (`balance`), and a fit that meets the stopping rule is checked on a fine
grid and by a proof; where its sign is or may be wrong, sign constraints are added and the fit is refined again
(`exchange`).

The constants of these modules were chosen on the 14 outlines and 9 closed surfaces of bench/QUALITY.md, mostly by a few
runs of the horse, the bird, the hammer, the bunny and the cow; no claim is made that they are optimal. On copies of all
shapes, rotated at random and thinned, on which no constant was chosen, the fits are as good.
"""

from functools import partial

import numpy as np

from ipcore._typing import FloatArray, IntArray
from ipcore.geometric import continuation
from ipcore.geometric.algebraic_start import exact_or
from ipcore.geometric.balance import balance
from ipcore.geometric.descent import AFTER_A_CHANGE, Descent
from ipcore.geometric.exchange import Exchange
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.levenberg_marquardt import Refined, condition
from ipcore.geometric.objective import DataTables, Objective
from ipcore.geometric.sign_constraints import SignConstraints, SignNodes
from ipcore.geometric.sizes import nodes_per_axis, points_used
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.points.outliers import crowded
from ipcore.polynomial import graded
from ipcore.polynomial.univariate import Basis
from ipcore.search.fitter import PrefixFit
from ipcore.search.stopping_rule import StoppingRule

NODES_WEIGHT = 10.0  # of all sign nodes together, against a mean squared distance
ALL_POINTS_EXCESS = 1.5  # below it, a fit is refined with all points
STEEP = 2.0  # a greater slope at the data has only a fit that was scaled to reach margins, see `algebraic_start`
OUTLIER_FACTOR = 5.0  # times t1, or times the median distance if that is more: points farther from a fit do not count


class GeometricFit:
    """A `Fitter` that fits complete degrees 1, 2, … in the normalised frame."""

    def __init__(self, data: OrientedPoints, options: FitOptions, max_degree: int, rule: StoppingRule) -> None:
        """Take the data, the highest degree that will be asked for, and the stopping rule."""
        self._data, self._options = data, options
        self._rule = rule
        count, d = data.points.shape
        self._last = graded.highest_determined(d, count, max_degree)
        self._weights = np.where(crowded(data.points), 1.0, 0.0) if options.robust else np.ones(count)
        trusted = self._weights > 0.0
        self._sides = InsideOutside(data.points[trusted], data.normals[trusted], data.bounds)
        self._nodes: dict[int, SignNodes] = {}
        self._exchange = Exchange(self._sides, data.bounds, data.thinned.points)
        self._order = np.random.default_rng(0).permutation(count)  # seeded: the same points get the same fit
        self._coefficients, self._degree = np.zeros(0), 0  # of the last fit

    def raise_to(self, alpha: int) -> PrefixFit:
        """Return the fit at the complete degree that has α columns."""
        degree, skipped = graded.degree_of(self._data.points.shape[1], alpha), 0
        for lower in range(self._degree + 1, degree):
            descent = self._descent(lower)
            self._coefficients = self._followed(descent).coefficients
            skipped += descent.iterations
        descent, self._degree = self._descent(degree), degree
        fit = self._with_all_points(descent, self._followed(descent))
        if self._options.on_geometric:
            fit = exact_or(descent, fit)
        self._coefficients = fit.coefficients  # the next degree starts here: without cuts, which it may not need
        fit, quiet = self._balanced(descent, fit), None
        if self._options.on_signs and (degree == self._last or descent.excess(fit) < 1.0):
            rebalanced = partial(self._balanced, descent)
            fit, quiet = self._exchange.run(descent, fit, rebalanced, last=degree == self._last)
        fitted = self._fitted(descent.objective, fit, skipped + descent.iterations, quiet)
        if self._options.robust:
            self._reweigh(degree, fit.coefficients)
        return fitted

    def orthogonality_loss(self, columns: int) -> None:
        """Return None: nothing is orthogonalised."""

    def _descent(self, degree: int) -> Descent:
        """Return the objective of a degree, over as many points as the degree needs."""
        data = self._tables(self._order[: points_used(self._data.points.shape[1], degree)])
        return Descent(Objective(data, degree, self._signs(degree), self._options.angle_weight), self._rule)

    def _tables(self, some: IntArray) -> DataTables:
        """Return the tables of the points with these numbers (n,), in the order of the data."""
        i = np.sort(some)
        return DataTables(self._data.points[i], self._data.normals[i], self._weights[i], self._data.bounds)

    def _signs(self, degree: int) -> list[SignConstraints]:
        """Return the sign constraints on the grid that a degree needs, as a list of one; of none without signs."""
        if not self._options.on_signs:
            return []
        count = nodes_per_axis(self._data.points.shape[1], degree)
        if count not in self._nodes:
            self._nodes[count] = SignNodes.of(self._sides, self._data.bounds, count, NODES_WEIGHT)
        return [self._nodes[count]]

    def _followed(self, descent: Descent) -> Refined:
        """Return the fit at the end of the homotopy."""
        return continuation.follow(descent, self._coefficients, geometric=self._options.on_geometric)

    def _with_all_points(self, descent: Descent, fit: Refined) -> Refined:
        """Return the fit, refined with all points if it was made with some and is near to meeting the rule."""
        objective = descent.objective
        if len(objective.data.weights) == len(self._order) or descent.excess(fit) >= ALL_POINTS_EXCESS:
            return fit
        objective.data = self._tables(self._order)
        return descent.refine(fit.coefficients, AFTER_A_CHANGE)

    def _balanced(self, descent: Descent, fit: Refined) -> Refined:
        """Return the fit with λ balanced; without the geometric refinement λ stays, for D_dist is not minimised."""
        return balance(descent, fit, self._options.angle_weight) if self._options.on_geometric else fit

    def _reweigh(self, degree: int, a: FloatArray) -> None:
        """Give weight 0 at the next degree to the points far from the fit with coefficients a (m,)."""
        distance = np.abs(self._data.polynomial(degree, a, Basis.CHEBYSHEV).distance(self._data.points))
        limit = OUTLIER_FACTOR * max(self._options.t1, float(np.median(distance)))
        self._weights = np.where(distance <= limit, 1.0, 0.0)

    def _fitted(self, objective: Objective, fit: Refined, iterations: int, quiet: bool | None) -> PrefixFit:  # noqa: FBT001 - see PrefixFit
        """Return the fit as the search wants it, with f about as large as the distance."""
        slope = float(np.sqrt(np.mean(np.square(fit.evaluation.size))))
        a = fit.coefficients / (slope if slope > STEEP else 1.0)
        polynomial = self._data.polynomial(objective.degree, a, Basis.CHEBYSHEV)
        objective.keep_data_matrix(1)
        H = objective.normal_equations(objective.evaluate(fit.coefficients))[0]
        conditioned, ratio = condition(H)
        distance = polynomial.distance(self._data.points)
        return PrefixFit(
            polynomial,
            rows=len(distance),
            columns=objective.columns,
            dropped=0,
            ridged=0,
            degrees_of_freedom=float(objective.columns),
            rss=float((distance**2).sum()),
            condition=conditioned,
            diagonal_ratio=ratio,
            loo=None,
            iterations=iterations,
            quiet=quiet,
            unsure=min((nodes.unsure for nodes in self._nodes.values()), default=None),
            weights=self._weights if self._options.robust else None,
        )
