"""The exchange method: sign constraints everywhere, of which only finitely many are ever in the objective.

The sign of f should be right at every place of the box whose side is known: infinitely many constraints on finitely
many coefficients, a semi-infinite program. The exchange method (Hettich and Kortanek, Semi-infinite programming:
theory, methods, and applications, SIAM Review 35, 1993) solves it with finitely many constraints, finds where the
solution violates the others, adds those as cuts, and solves again, until no violation is found or the rounds are used
up.
"""

from collections.abc import Callable

import numpy as np

from ipcore._typing import FloatArray
from ipcore.geometric.cuts import cuts
from ipcore.geometric.descent import Descent
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.levenberg_marquardt import Effort, Refined
from ipcore.geometric.sign_constraints import BOUNDS_GROWTH, SignNodes, SignPoints
from ipcore.geometric.violations import ViolationGrid, Violations
from ipcore.polynomial import evaluation
from ipcore.zero_set.survey import STRAY_RESOLUTION

# Lines per axis of the grids on which violations are looked for, and by what factor the bounds are grown. The first is
# as fine as the grid on which the result's stray share is measured, so that the two agree; the second is finer.
GRIDS = {
    2: ((STRAY_RESOLUTION[2], 1.0), (501, BOUNDS_GROWTH)),
    3: ((STRAY_RESOLUTION[3], 1.0), (129, BOUNDS_GROWTH)),
}
# Tuned on the shapes of bench/QUALITY.md, see `ipcore.geometric.fit`.
CUT_WEIGHT = 0.02  # of each cut, against a mean squared distance
NODES_FACTOR = 3.0  # by which the weight of all nodes grows when there is a violation
CUT_FACTOR = 3.0  # by which the weight of a cut grows in each round in which f still has the wrong sign there
EXCHANGE_ROUNDS, LAST_EXCHANGE_ROUNDS = 8, 16  # at most; the last degree has no next one to hope for
EXCHANGE_EFFORT = Effort(10, 1e-3, 2)
GIVE_UP_EXCESS = 1.2  # above it the exchange ends, unless the degree is the last


class Exchange:
    """The grids on which a fit is checked, and the loop that removes what they find."""

    def __init__(self, sides: InsideOutside, bounds: FloatArray) -> None:
        """Take the known sides and the bounds (2, d)."""
        self._sides, self._dimension = sides, bounds.shape[1]
        self._grids = [ViolationGrid(sides, bounds, *grid) for grid in GRIDS[self._dimension]]

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
        """Return the violations and the cuts on the first grid that gives cuts; else those of the last grid, and None.

        `a` (m,) are Chebyshev coefficients of that degree.
        """
        tensor = evaluation.to_tensor(a, self._dimension, degree)
        for grid in self._grids:
            found = grid.find(tensor)
            suspicious = found.suspect.any() or len(found.subgrid) > 0
            more = cuts(found, grid, self._sides) if suspicious else None
            if more is not None:
                return found, SignPoints(more.t, more.side, more.margin, np.full(len(more.t), CUT_WEIGHT))
        return found, None


def _extended(points: SignPoints, fit: Refined, more: SignPoints) -> SignPoints:
    """Return the cuts so far, heavier where the fit still has the wrong sign, and more; they are the fit's last set."""
    return points.reweighted(fit.evaluation.shortfalls[-1], CUT_FACTOR).with_more(more)
