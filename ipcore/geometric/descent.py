"""One degree's objective, decreased again and again as it changes, with a count of the iterations."""

from ipcore._typing import FloatArray
from ipcore.geometric.levenberg_marquardt import Effort, Refined, refine
from ipcore.geometric.objective import Objective
from ipcore.search.criteria import StoppingRule

AFTER_A_CHANGE = Effort(15, 1e-3, 2)  # when more points or another λ have moved the minimum a little; see `fit`


class Descent:
    """An objective and the stopping rule that its fits should meet.

    Attributes
    ----------
    objective
        What is decreased. Continuation, balance and exchange change its t, λ and sign constraints.
    rule
        The stopping rule.
    iterations
        The number of Levenberg–Marquardt steps so far.

    """

    def __init__(self, objective: Objective, rule: StoppingRule) -> None:
        """Begin with no iteration."""
        self.objective, self.rule, self.iterations = objective, rule, 0

    def refine(self, a: FloatArray, effort: Effort) -> Refined:
        """Return the fit after steps from the coefficients a (m,)."""
        fit = refine(self.objective, a, effort)
        self.iterations += fit.steps
        return fit

    def excess(self, fit: Refined) -> float:
        """Return how far a fit is from meeting the rule; below 1 it is met."""
        return self.rule.excess(*self.objective.closeness(fit.evaluation))

    def excesses(self, fit: Refined) -> tuple[float, float]:
        """Return the excess of D_dist and that of D_smooth, of which the rule takes the larger one."""
        return self.rule.excesses(*self.objective.closeness(fit.evaluation))
