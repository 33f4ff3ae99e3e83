"""The geometric fit under sign constraints, at one degree after another.

Every degree starts from the fit of the one below, a prefix in the graded order, and follows the homotopy of
`ipcore.geometric.objective` to t = 1. A fit that meets the stopping rule is surveyed on fine grids; what is wrong there
becomes further sign constraints, and it is refined again, until nothing is wrong or too many rounds have passed.
"""

from dataclasses import dataclass

import numpy as np

from ipcore._typing import FloatArray, IntArray
from ipcore.geometric.exchange import Exchange
from ipcore.geometric.inside_outside import InsideOutside, crowded
from ipcore.geometric.levenberg_marquardt import Refined, condition, refine
from ipcore.geometric.objective import DataTables, Objective
from ipcore.geometric.sign_constraints import SignConstraints, SignNodes
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial import graded
from ipcore.polynomial.univariate import Basis
from ipcore.search.fitter import PrefixFit
from ipcore.search.stopping_rule import StoppingRule

# All of these were chosen on the 14 outlines and 9 closed surfaces of bench/QUALITY.md, mostly by a few runs of the
# horse, the bird, the hammer, the bunny and the cow; no claim is made that they are optimal. On copies of all, rotated
# at random and thinned, which no constant saw, the fits are as good.
# The homotopy: from nothing at the first degrees, from the prefix later. Skipping 0.7 and 0.95 from the prefix leaves
# fits stuck, with gradients that have turned over for good: the horse then needs degree 16 or 17 in place of 14.
COLD = (0.0, 0.7, 0.95, 1.0)
WARM = (0.7, 0.95, 1.0)
COLD_DEGREES = 2
SIGN_WEIGHT = 10.0  # of the mean over all nodes of the box
PER_DEGREE = {2: 10, 3: 6}  # nodes per degree and axis
FEWEST, STEP = 33, 16  # nodes per axis at least, and in what steps they grow, so that few grids are made
SUBSET, PER_COLUMN = 2000, 6  # points that a fit is made from at first, at least, and per coefficient
NEARLY = 1.5  # excess below which a fit is refined on all points, balanced, and surveyed
ROUNDS, LAST_ROUNDS = 8, 16  # of repairs, at most; the last degree has no next one to hope for
HEAVIER = 3.0  # what the weight of all nodes grows by when something is wrong
BOOST = 3.0  # what the weight of a repair's place grows by while it is still wrong
# λ is moved by (excess of D_smooth / excess of D_dist)^1.5 while one is met and the other is not, by 100 at most.
BALANCES, BALANCE, RANGE = 3, 1.5, 100.0
WORTH = 1.3  # product of the two excesses above which balancing is hopeless


@dataclass(frozen=True)
class Effort:
    """When to stop refining: after so many steps, or `patience` running that gain less than `tolerance` each."""

    steps: int
    tolerance: float
    patience: int


ON_THE_WAY = Effort(8, 1e-2, 1)
FULL = Effort(40, 1e-3, 2)
AGAIN = Effort(15, 1e-3, 2)
REPAIR = Effort(10, 1e-3, 2)
GIVE_UP = 1.2  # excess above which a repair at less than the last degree is given up
OUTLYING = 5.0  # times t1, or the median distance if that is more: how far from one degree's fit the next leaves out


class GeometricFit:
    """Fits of degree 1, 2, … in the normalised frame; `raise_to` is all that the search needs."""

    def __init__(self, data: OrientedPoints, options: FitOptions, max_degree: int, rule: StoppingRule) -> None:
        """Take the data and the stopping rule; no degree above `max_degree` will be asked for."""
        self._data, self._options = data, options
        self._rule = rule
        count, d = data.points.shape
        self._last = max((n for n in range(1, max_degree + 1) if graded.count(d, n) <= count), default=1)
        self._weights = np.where(crowded(data.points), 1.0, 0.0) if options.robust else np.ones(count)
        trusted = self._weights > 0.0
        self._sides = InsideOutside(data.points[trusted], data.normals[trusted], data.bounds)
        self._nodes: dict[int, SignNodes] = {}
        self._exchange = Exchange(self._sides, data.bounds)
        self._order = np.random.default_rng(0).permutation(count)  # seeded: the same points get the same fit
        self._prefix, self._reached = np.zeros(0), 0
        self._iterations = 0

    def raise_to(self, alpha: int) -> PrefixFit:
        """Fit at the complete degree with α columns."""
        degree, self._iterations = graded.degree_of(self._data.points.shape[1], alpha), 0
        for lower in range(self._reached + 1, degree):
            self._prefix = self._followed(self._objective(lower)).coefficients
        objective, self._reached = self._objective(degree), degree
        fit = self._followed(objective)
        if len(objective.data.weights) < len(self._order) and self._excess(objective, fit) < NEARLY:
            objective.data = self._tables(self._order)
            fit = self._refined(objective, fit.coefficients, AGAIN)
        self._prefix = fit.coefficients
        fit, quiet = self._balanced(objective, fit), None
        if self._options.on_signs and (degree == self._last or self._excess(objective, fit) < 1.0):
            fit, quiet = self._settled(objective, fit)
        step = self._step(objective, fit, quiet)
        if self._options.robust:
            self._reweigh(degree, fit.coefficients)
        return step

    def orthogonality_loss(self, columns: int) -> None:
        """Return None: nothing is orthogonalised."""

    def _objective(self, degree: int) -> Objective:
        """Take as many points as the degree needs."""
        columns = graded.count(self._data.points.shape[1], degree)
        data = self._tables(self._order[: max(SUBSET, PER_COLUMN * columns)])
        return Objective(data, degree, self._signs(degree), self._options.angle_weight)

    def _tables(self, some: IntArray) -> DataTables:
        """Tabulate these points, in their order."""
        i = np.sort(some)
        return DataTables(self._data.points[i], self._data.normals[i], self._weights[i], self._data.bounds)

    def _signs(self, degree: int) -> list[SignConstraints]:
        """Return the sign constraints on the grid that this degree needs."""
        if not self._options.on_signs:
            return []
        wanted = PER_DEGREE[self._data.points.shape[1]] * degree
        count = max(FEWEST, 1 + STEP * -(-wanted // STEP))
        if count not in self._nodes:
            self._nodes[count] = SignNodes.of(self._sides, self._data.bounds, count, SIGN_WEIGHT)
        return [self._nodes[count]]

    def _followed(self, objective: Objective) -> Refined:
        """Follow the homotopy."""
        cold = objective.degree <= COLD_DEGREES or not self._options.on_geometric
        a = np.zeros(objective.columns)
        if not cold:
            a[: len(self._prefix)] = self._prefix
        path = (COLD if cold else WARM) if self._options.on_geometric else COLD[:1]
        for objective.blend in path[:-1]:
            a = self._refined(objective, a, ON_THE_WAY).coefficients
        objective.blend = path[-1]
        return self._refined(objective, a, FULL)

    def _refined(self, objective: Objective, a: FloatArray, effort: Effort) -> Refined:
        fit = refine(objective, a, effort.steps, effort.tolerance, effort.patience)
        self._iterations += fit.steps
        return fit

    def _excess(self, objective: Objective, fit: Refined) -> float:
        return self._rule.excess(*objective.closeness(fit.evaluation))

    def _balanced(self, objective: Objective, fit: Refined) -> Refined:
        """Move λ while one half of the rule is met and the other is nearly."""
        best, given, kept = fit, self._options.angle_weight, objective.angle_weight
        for _ in range(BALANCES):
            far, turned = self._rule.excesses(*objective.closeness(fit.evaluation))
            if not self._options.on_geometric or max(far, turned) < 1.0 or min(far, turned) > WORTH / max(far, turned):
                break
            quotient = float(np.clip(turned / max(far, 1.0 / RANGE), 1.0 / RANGE, RANGE))
            moved = objective.angle_weight * quotient**BALANCE
            objective.angle_weight = min(max(moved, given / RANGE), given * RANGE)
            fit = self._refined(objective, fit.coefficients, AGAIN)
            if self._excess(objective, fit) >= self._excess(objective, best):
                break
            best, kept = fit, objective.angle_weight
        objective.angle_weight = kept
        return best

    def _settled(self, objective: Objective, fit: Refined) -> tuple[Refined, bool]:
        """Ask for what surveys find missing, until they find nothing; return the fit, and whether it came to that.

        If it did not, the fit is the one with the least stray, then the fewest components, then the least excess.
        """
        degree, more = objective.degree, None
        grid = [nodes.heavier(HEAVIER) for nodes in objective.signs if isinstance(nodes, SignNodes)]
        best, least = fit, (np.inf, np.inf, np.inf)
        for _ in range(LAST_ROUNDS if degree == self._last else ROUNDS):
            found, asked = self._exchange.next_cuts(degree, fit.coefficients)
            if asked is None:
                return fit, True
            rank = found.stray, found.components, self._excess(objective, fit)
            if rank < least:
                best, least = fit, rank
            more = asked if more is None else more.reweighted(fit.evaluation.shortfalls[-1], BOOST).with_more(asked)
            objective.signs = [*grid, more]
            fit = self._refined(objective, fit.coefficients, REPAIR)
            if degree < self._last and self._excess(objective, fit) > GIVE_UP:
                break
            if self._excess(objective, fit) > 1.0:
                fit = self._balanced(objective, fit)
        return best, False

    def _reweigh(self, degree: int, a: FloatArray) -> None:
        """Leave out at the next degree the points that are far from this fit."""
        distance = np.abs(self._data.polynomial(degree, a, Basis.CHEBYSHEV).distance(self._data.points))
        limit = OUTLYING * max(self._options.t1, float(np.median(distance)))
        self._weights = np.where(distance <= limit, 1.0, 0.0)

    def _step(self, objective: Objective, fit: Refined, quiet: bool | None) -> PrefixFit:  # noqa: FBT001 - see PrefixFit
        polynomial = self._data.polynomial(objective.degree, fit.coefficients, Basis.CHEBYSHEV)
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
            iterations=self._iterations,
            quiet=quiet,
            unsure=min((nodes.unsure for nodes in self._nodes.values()), default=None),
            weights=self._weights if self._options.robust else None,
        )
