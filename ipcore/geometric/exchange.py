"""The exchange method: sign constraints everywhere, of which only finitely many are ever in the objective.

The sign of f should be right at every place of the box whose side is known: infinitely many constraints on finitely
many coefficients, a semi-infinite program. The exchange method (Hettich and Kortanek, Semi-infinite programming:
theory, methods, and applications, SIAM Review 35, 1993) solves it with finitely many constraints, finds where the
solution violates the others, adds those as cuts, and solves again, until no violation is found or the rounds are used
up.

Violations are first looked for on a grid, which is cheap and also shows parts that are cut off. When it shows none, it
is tried to prove that f has no zero away from the data; the blocks in which zeros cannot be excluded give cuts, too.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ipcore._typing import FloatArray
from ipcore.geometric.cuts import CUT_SLOPE, LARGEST_CUT_MARGIN, cuts
from ipcore.geometric.descent import Descent
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.levenberg_marquardt import Effort, Refined
from ipcore.geometric.sign_constraints import SignNodes, SignPoints
from ipcore.geometric.violations import ViolationGrid, Violations
from ipcore.polynomial import evaluation
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.proof.parts import Parts
from ipcore.proof.prover import clear
from ipcore.proof.tube import Tube
from ipcore.zero_set.survey import STRAY_RESOLUTION

# Tuned on the shapes of bench/QUALITY.md, see `ipcore.geometric.fit`.
# Where zeros could not be excluded so many places at most get cuts. Parts of more cells than these a grid shows.
MOST_UNPROVED, SHOWN_CELLS = 500, 4.0
CUT_WEIGHT = 0.02  # of each cut, against a mean squared distance
NODES_FACTOR = 3.0  # by which the weight of all nodes grows when there is a violation
CUT_FACTOR = 3.0  # by which the weight of a cut grows in each round in which f still has the wrong sign there
EXCHANGE_ROUNDS, LAST_EXCHANGE_ROUNDS = 8, 16  # at most; the last degree has no next one to hope for
EXCHANGE_EFFORT = Effort(10, 1e-3, 2)
# Steps for which the data's part of the Gauss–Newton matrix is kept, which in the plane costs little: cuts move a fit
# little, and the gradient is exact.
STEPS_WITH_CUTS = {2: 1, 3: 10}
GIVE_UP_EXCESS = 1.2  # above it the exchange ends, unless the degree is the last


class Exchange:
    """The checks of a fit, and the loop that removes what they find."""

    def __init__(self, sides: InsideOutside, bounds: FloatArray, points: FloatArray) -> None:
        """Take the known sides, the bounds (2, d), and the data (N, d) near which zeros may lie."""
        self._sides, self._bounds, self._points, self._dimension = sides, bounds, points, bounds.shape[1]
        # as fine as the grid on which the result's stray share is measured, so that the two agree
        self._grid = ViolationGrid(sides, bounds, STRAY_RESOLUTION[bounds.shape[1]])

    def run(
        self, descent: Descent, fit: Refined, rebalanced: Callable[[Refined], Refined], *, last: bool
    ) -> tuple[Refined, bool]:
        """Refine a fit under more and more cuts; return the fit, and whether it has no violation that is known.

        If it has, it is the one with the least stray share, then the fewest components, then the least excess.

        Parameters
        ----------
        descent
            The objective; its sign constraints are changed here.
        fit
            Its minimum so far.
        rebalanced
            Balances λ of a fit that the cuts have moved away from the stopping rule.
        last
            Whether this is the last degree: then no fit is given up for a higher degree.

        """
        objective, points = descent.objective, None
        nodes = [grid.heavier(NODES_FACTOR) for grid in objective.signs if isinstance(grid, SignNodes)]
        objective.keep_data_matrix(STEPS_WITH_CUTS[self._dimension])
        best, least = fit, (np.inf, np.inf, np.inf)
        for _ in range(LAST_EXCHANGE_ROUNDS if last else EXCHANGE_ROUNDS):
            found, more = self.next_cuts(objective.degree, fit.coefficients)
            if more is None:
                return fit, True
            rank = found.stray, found.components, descent.excess(fit)
            if rank < least:
                best, least = fit, rank
            points = more if points is None else _extended(points, fit, more)
            objective.signs = [*nodes, points]
            fit = descent.refine(fit.coefficients, EXCHANGE_EFFORT)
            if not last and descent.excess(fit) > GIVE_UP_EXCESS:
                break
            if descent.excess(fit) > 1.0:
                fit = rebalanced(fit)
        return best, False

    def next_cuts(self, degree: int, a: FloatArray) -> tuple[Violations, SignPoints | None]:
        """Return the violations on the grid, and cuts: those that the grid gives, else those where a proof fails.

        None if there are neither. `a` (m,) are Chebyshev coefficients of that degree.
        """
        found = self._grid.find(evaluation.to_tensor(a, self._dimension, degree))
        more = cuts(found, self._grid, self._sides) if found.suspect.any() or len(found.subgrid) else None
        if more is None:
            return found, self._unproved(degree, a)
        return found, SignPoints(more.t, more.side, more.margin, np.full(len(more.t), CUT_WEIGHT))

    def _unproved(self, degree: int, a: FloatArray) -> SignPoints | None:
        """Return cuts where zeros away from the data cannot be excluded; None if there are none, or nothing is known.

        If there surely are such zeros, the grid has given no cuts for the parts that it shows because the data do not
        tell the side there: the scan is open. These are left.
        """
        frame = Frame(np.zeros(self._dimension), 1.0)
        cleared = clear(ImplicitPolynomial(degree, a, frame, self._bounds, Basis.CHEBYSHEV), self._tube)
        parts = Parts.of(cleared.left, self._dimension)
        shown = parts.radius > SHOWN_CELLS * self._grid.cell
        x = parts.middle[~shown[parts.part]] if cleared.hopeless else parts.middle
        x = x[:: 1 + len(x) // MOST_UNPROVED]
        located = self._sides.classify(x)
        sure = located.side != 0.0
        margin = np.minimum(CUT_SLOPE * located.distance, LARGEST_CUT_MARGIN)
        weight = np.full(int(sure.sum()), CUT_WEIGHT)
        return SignPoints(self._grid.cube(x[sure]), located.side[sure], margin[sure], weight) if sure.any() else None

    @cached_property
    def _tube(self) -> Tube:
        """The tube about the data, made when the first fit is good enough to be checked."""
        return Tube(self._points)


def _extended(points: SignPoints, fit: Refined, more: SignPoints) -> SignPoints:
    """Return the cuts so far, heavier where the fit still has the wrong sign, and more; they are the fit's last set."""
    return points.reweighted(fit.evaluation.shortfalls[-1], CUT_FACTOR).with_more(more)
