"""Which of the fits is best, and when to look no further: one judge per criterion, plugged into the search."""

from typing import Protocol

from ipcore.options.choices import Criterion
from ipcore.options.fit_options import FitOptions
from ipcore.search.criteria import StoppingRule
from ipcore.search.result import Step, StopReason

# How many degrees without a better one end the search for a minimum. Even and odd degrees fit differently well, so two
# would compare too few of a kind; on six outlines with noise 0.005 and 0.02, up to degree 18, three found the same
# minimum as looking at every degree in 23 of 24 searches by gcv and bic.
LOOK_AHEAD = 3
# Larger than any excess: of fits under sign constraints the quiet come first, then those that were at least surveyed
# and repaired. Linear fits are not surveyed, so among them it changes nothing.
LOUD = {True: 0.0, False: 1e6, None: 2e6}


class Judge(Protocol):
    """Compares fits as they are made."""

    exhausted: StopReason

    def score(self, step: Step) -> float:
        """Return how bad a fit is; the least is the best."""
        ...

    def verdict(self, step: Step, best: Step) -> StopReason | None:
        """Return why to stop after this step, or None to go on; `best` has the least score so far."""
        ...


class DistanceJudge:
    """The paper's rule (7): the first fit that is close and smooth enough, else the one that is nearest to being so.

    Fits under sign constraints must be quiet, too; quiet ones are better than all others.
    """

    exhausted = StopReason.MAX_DEGREE

    def __init__(self, rule: StoppingRule) -> None:
        """Judge by this rule."""
        self._rule = rule

    def score(self, step: Step) -> float:
        """Return by what factor the fit misses the rule, and much more unless it is known to be quiet."""
        return self._rule.excess(step.d_dist, step.d_smooth) + LOUD[step.quiet]

    def verdict(self, step: Step, best: Step) -> StopReason | None:  # noqa: ARG002 - the rule looks at one fit alone
        """Stop when the rule is met."""
        met = self._rule.met(step.d_dist, step.d_smooth) and step.quiet is not False
        return StopReason.CRITERION_MET if met else None


class MinimumJudge:
    """The minimum of an estimated error: gcv, bic or loo."""

    exhausted = StopReason.MAX_DEGREE

    def __init__(self, criterion: Criterion) -> None:
        """Judge by the step's member of this name."""
        self._name = str(criterion)

    def score(self, step: Step) -> float:
        """Return the estimate."""
        return float(getattr(step, self._name))

    def verdict(self, step: Step, best: Step) -> StopReason | None:
        """Stop when the best fit lies `LOOK_AHEAD` degrees back."""
        return StopReason.CRITERION_MINIMUM if step.degree >= best.degree + LOOK_AHEAD else None


class LastJudge:
    """No criterion: every fit is better than the one before."""

    def __init__(self, exhausted: StopReason = StopReason.DEGREE_REACHED) -> None:
        """End with this reason."""
        self.exhausted = exhausted

    def score(self, step: Step) -> float:
        """Return −α."""
        return -float(step.alpha)

    def verdict(self, step: Step, best: Step) -> None:
        """Go on."""


def judge(options: FitOptions) -> Judge:
    """Return the judge of the chosen criterion."""
    if options.criterion is Criterion.DISTANCE:
        return DistanceJudge(StoppingRule(options.t1, options.t2))
    return LastJudge() if options.criterion is Criterion.NONE else MinimumJudge(options.criterion)
