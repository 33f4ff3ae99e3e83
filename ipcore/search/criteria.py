r"""The stopping criteria: each has a value for every fit of the search, and says after which fit the search ends.

`distance` is the paper's rule (section 4.2). On noisy data D_dist stays near the noise and the rule may never be met.
The factorisation then gives, at hardly any cost, three estimates of the error at points that were not fitted. Each has
a minimum over the degrees:

GCV = n · RSS / (n − k)²              Golub, Heath and Wahba 1979; n rows, k degrees of freedom
BIC = n ln(RSS / n) + k ln n          Schwarz 1978
LOO                                   see `ipcore.search.leverage`

A new criterion is one class here, one member of `Criterion`, and one line of the table at the end.
"""

from abc import ABC, abstractmethod
from dataclasses import replace

import numpy as np

from ipcore.options.choices import Criterion
from ipcore.options.fit_options import FitOptions
from ipcore.search.coverage import LEAST_COVERAGE
from ipcore.search.fitter import PrefixFit
from ipcore.search.result import Step
from ipcore.search.stop_reason import StopReason
from ipcore.search.stopping_rule import StoppingRule

# How many degrees without a better one end the search for a minimum. Even and odd degrees fit differently well, so two
# would compare too few of a kind; on six outlines with noise 0.005 and 0.02, up to degree 18, three found the same
# minimum as trying every degree in 23 of 24 searches by gcv and bic.
DEGREES_PAST_MINIMUM = 3
# Added to the excess, by `quiet`, and larger than any excess: of fits under sign constraints those with a quiet zero
# set come first, then those whose zero set was checked and corrected. Linear fits are not checked (None), so among them
# it changes no order.
NOT_QUIET_PENALTY = {True: 0.0, False: 1e6, None: 2e6}
NOT_COVERED_PENALTY = 4e6  # the same for a fit without zeros near the data, which is worse than all others


class StoppingCriterion(ABC):
    """Compares the fits of one search as they are made.

    Attributes
    ----------
    rule
        Eq. (7) with the thresholds of the options; the geometric fit needs it whatever the criterion is.
    exhausted
        The reason to stop when all degrees were tried.
    never_stops
        Whether no fit ever ends the search.

    """

    exhausted = StopReason.MAX_DEGREE
    never_stops = False

    def __init__(self, rule: StoppingRule) -> None:
        """Take the rule."""
        self.rule = rule

    def record(self, step: Step, fit: PrefixFit) -> Step:  # noqa: ARG002 - for values that a Step does not always have
        """Return the step with this criterion's value of the fit in it."""
        return step

    @abstractmethod
    def score(self, step: Step) -> float:
        """Return the criterion's value; the fit with the least is the best."""

    @abstractmethod
    def verdict(self, step: Step, best: Step) -> StopReason | None:
        """Return why to stop after this step, or None to go on; `best` has the least score so far."""


class PaperRule(StoppingCriterion):
    """The paper's rule (7): the first fit that is close and smooth enough, else the one nearest to it.

    Under sign constraints the zero set must be quiet, too; every quiet fit is better than all others. And the data must
    have zeros of f near them: f can be small and smooth at all of them without any zero.
    """

    def score(self, step: Step) -> float:
        """Return the excess over the rule, with the penalties of a zero set that is not quiet or not at the data."""
        excess = self.rule.excess(step.d_dist, step.d_smooth) + NOT_QUIET_PENALTY[step.quiet]
        return excess if _covers(step) else excess + NOT_COVERED_PENALTY

    def verdict(self, step: Step, best: Step) -> StopReason | None:  # noqa: ARG002 - the rule compares no fits
        """Stop when the rule is met."""
        met = self.rule.met(step.d_dist, step.d_smooth) and step.quiet is not False and _covers(step)
        return StopReason.CRITERION_MET if met else None


class EstimatedErrorMinimum(StoppingCriterion):
    """The minimum over the degrees of an estimated error."""

    def verdict(self, step: Step, best: Step) -> StopReason | None:
        """Stop when the best fit lies `DEGREES_PAST_MINIMUM` degrees back."""
        return StopReason.CRITERION_MINIMUM if step.degree >= best.degree + DEGREES_PAST_MINIMUM else None


class GeneralisedCrossValidation(EstimatedErrorMinimum):
    """The minimum of GCV, which every step has."""

    def score(self, step: Step) -> float:
        """Return GCV."""
        return step.gcv


class BayesianInformation(EstimatedErrorMinimum):
    """The minimum of BIC."""

    def record(self, step: Step, fit: PrefixFit) -> Step:
        """Return the step with BIC."""
        return replace(step, bic=bic(fit.rows, fit.degrees_of_freedom, fit.rss))

    def score(self, step: Step) -> float:
        """Return BIC."""
        return _known(step.bic)


class LeaveOneOut(EstimatedErrorMinimum):
    """The minimum of LOO, which a fit that holds Q computes."""

    def record(self, step: Step, fit: PrefixFit) -> Step:
        """Return the step with LOO."""
        return replace(step, loo=fit.loo)

    def score(self, step: Step) -> float:
        """Return LOO."""
        return _known(step.loo)


class LastDegree(StoppingCriterion):
    """No criterion: every fit is better than the one before."""

    exhausted = StopReason.DEGREE_REACHED
    never_stops = True

    def score(self, step: Step) -> float:
        """Return −α."""
        return -float(step.alpha)

    def verdict(self, step: Step, best: Step) -> None:
        """Go on."""


def gcv(rows: int, degrees_of_freedom: float, rss: float) -> float:
    """Return generalised cross-validation; infinite where the fit interpolates.

    >>> gcv(10, 5.0, 1.0)
    0.4
    """
    free = rows - degrees_of_freedom
    return rows * rss / free**2 if free > 0.0 else float("inf")


def bic(rows: int, degrees_of_freedom: float, rss: float) -> float:
    """Return Schwarz' criterion, up to a constant.

    Its minimum is at a lower degree than those of the other two. The rows of one point are counted as independent,
    which they are not: counting points instead of rows, the search stopped far too early, on outlines with noise 0.02
    at up to twice the error.

    >>> bic(300, 0.0, 300.0)
    0.0
    """
    return float(rows * np.log(max(rss / rows, np.finfo(float).tiny)) + degrees_of_freedom * np.log(rows))


def _covers(step: Step) -> bool:
    """Return whether the zero set is near the data, as far as that was checked."""
    return step.coverage is None or step.coverage >= LEAST_COVERAGE


def _known(value: float | None) -> float:
    """Return a value that `record` has put into the step."""
    if value is None:
        raise ValueError("the step does not have the value of this criterion")
    return value


_CRITERIA: dict[Criterion, type[StoppingCriterion]] = {
    Criterion.DISTANCE: PaperRule,
    Criterion.GCV: GeneralisedCrossValidation,
    Criterion.BIC: BayesianInformation,
    Criterion.LOO: LeaveOneOut,
    Criterion.NONE: LastDegree,
}


def stopping_criterion(options: FitOptions) -> StoppingCriterion:
    """Return the criterion that the options name."""
    return _CRITERIA[options.criterion](StoppingRule(options.t1, options.t2))
