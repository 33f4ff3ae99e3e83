"""The search for the degree: fit, measure, compare, go on (the paper's section 4.3).

The method of fitting and the stopping criterion are plugged in; the loop is written once.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

from ipcore.options.choices import Granularity
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial import graded
from ipcore.search.closeness import Closeness, closenesses
from ipcore.search.coverage import coverage
from ipcore.search.criteria import StoppingCriterion, gcv
from ipcore.search.fitter import Fitter, PrefixFit
from ipcore.search.result import Step
from ipcore.search.stop_reason import StopReason

Progress = Callable[[Step], None]


@dataclass(frozen=True, eq=False)
class Candidate:
    """One fit of the search, how close it is to the data, and its entry in the trace."""

    fit: PrefixFit
    closeness: Closeness
    step: Step


def column_counts(dimension: int, max_degree: int, granularity: Granularity) -> Sequence[int]:
    """Return the numbers of columns α at which a search makes a fit, up to the degree `max_degree`.

    Form by form from degree 1, or column by column from α = 2, the first that has a gradient.

    >>> list(column_counts(2, 3, Granularity.FORM)), list(column_counts(2, 2, Granularity.MONOMIAL))
    ([3, 6, 10], [2, 3, 4, 5, 6])
    """
    if granularity is Granularity.MONOMIAL:
        return range(2, graded.count(dimension, max_degree) + 1)
    return [graded.count(dimension, degree) for degree in range(1, max_degree + 1)]


class DegreeSearch:
    """The loop over numbers of columns: each fit is made, measured and kept in the trace; the best is remembered.

    Attributes
    ----------
    steps
        The trace so far.
    data, options, fitter
        As given.

    """

    def __init__(self, data: OrientedPoints, options: FitOptions, fitter: Fitter, criterion: StoppingCriterion) -> None:
        """Search on these data with this method of fitting and this criterion."""
        self.steps: list[Step] = []
        self.data, self.options, self.fitter = data, options, fitter
        self._criterion = criterion

    def run(self, alphas: Sequence[int], progress: Progress | None) -> tuple[Candidate, StopReason]:
        """Try numbers of columns α, in rising order, until the criterion says stop or no more can be fitted.

        Return the best fit and why the search ended. `progress` is called with every step.
        """
        best: Candidate | None = None
        determined = self._determined(alphas)
        reason = self._criterion.exhausted if len(determined) == len(alphas) else StopReason.TOO_FEW_POINTS
        for batch in self._batches(determined, progress):
            candidates = self._fit(batch)
            for candidate in candidates:
                if best is None or self._criterion.score(candidate.step) < self._criterion.score(best.step):
                    best = candidate
                self.steps.append(candidate.step)
                if progress is not None:
                    progress(candidate.step)
                verdict = self._criterion.verdict(candidate.step, best.step)
                if verdict is not None:
                    return best, verdict
            if len(candidates) < len(batch):
                reason = StopReason.ILL_CONDITIONED
                break
        if best is None:
            raise ValueError("a search needs at least one number of columns")
        return best, reason

    def _determined(self, alphas: Sequence[int]) -> Sequence[int]:
        """Return the first α, and those that the points determine, which are up to one more than there are points."""
        most = max(self.data.count, self.data.points.shape[1]) + 1
        return [alpha for k, alpha in enumerate(alphas) if not k or alpha <= most]

    def _batches(self, alphas: Sequence[int], progress: Progress | None) -> Sequence[Sequence[int]]:
        """Return the α in batches whose fits are measured in one pass over the data.

        All α are one batch if every one will be tried and there is no `progress` to report to; else each is its own.
        """
        if progress is None and self._criterion.never_stops and self.options.is_linear:
            return [alphas] if alphas else []
        return [[alpha] for alpha in alphas]

    def _fit(self, alphas: Sequence[int]) -> list[Candidate]:
        """Return the fits with these numbers of columns; fewer if not all of them are determined."""
        fits, seconds, started = [], [], perf_counter()
        for alpha in alphas:
            fit = self.fitter.raise_to(alpha)
            if fit is None:
                break
            fits.append(fit)
            seconds.append(perf_counter() - started)
            started = perf_counter()
        if not fits:
            return []
        measured = closenesses([fit.polynomial for fit in fits], self.data, fits[0].weights)
        share = (perf_counter() - started) / len(fits)
        return [
            Candidate(fit, closeness, self._step(fit, closeness, self._coverage(fit, closeness), one + share))
            for fit, closeness, one in zip(fits, measured, seconds, strict=True)
        ]

    def _coverage(self, fit: PrefixFit, closeness: Closeness) -> float | None:
        """Return the share of the data near a zero of f, if D_dist < T₁, as the stopping rule wants it; else None."""
        if closeness.d_dist >= self._criterion.rule.t1:
            return None
        return coverage(fit.polynomial, self.data, self.options.t1, fit.weights)

    def _step(self, fit: PrefixFit, closeness: Closeness, covered: float | None, seconds: float) -> Step:
        step = Step(
            degree=fit.polynomial.degree,
            columns=fit.columns,
            dropped=fit.dropped,
            d_dist=closeness.d_dist,
            d_smooth=closeness.d_smooth,
            rss=fit.rss,
            gcv=gcv(fit.rows, fit.degrees_of_freedom, fit.rss),
            condition=fit.condition,
            seconds=seconds,
            ridged=fit.ridged,
            diagonal_ratio=fit.diagonal_ratio,
            iterations=fit.iterations,
            quiet=fit.quiet,
            coverage=covered,
        )
        return self._criterion.record(step, fit)
