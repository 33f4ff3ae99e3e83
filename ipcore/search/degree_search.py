"""The search for the degree: fit, measure, judge, go on (the paper's section 4.3).

What fits at each stop and what judges the fits are plugged in; the loop is written once.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

from ipcore.options.choices import Criterion, Granularity
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial import graded
from ipcore.search import criteria
from ipcore.search.closeness import closenesses
from ipcore.search.criteria import Closeness
from ipcore.search.fitter import Fitted, Fitter
from ipcore.search.result import Step, StopReason
from ipcore.search.stopping import Judge

Progress = Callable[[Step], None]


@dataclass(frozen=True, eq=False)
class Found:
    """How a search ended: its best fit, in the normalised frame, and what was noted and seen of it."""

    fitted: Fitted
    step: Step
    at: Closeness
    reason: StopReason


def stops(dimension: int, cap: int, granularity: Granularity) -> Sequence[int]:
    """Return the numbers of columns α at which a search looks at the fit, up to the degree `cap`.

    Form by form from degree 1, or column by column from α = 2, the first that has a gradient.

    >>> list(stops(2, 3, Granularity.FORM)), list(stops(2, 2, Granularity.MONOMIAL))
    ([3, 6, 10], [2, 3, 4, 5, 6])
    """
    if granularity is Granularity.MONOMIAL:
        return range(2, graded.count(dimension, cap) + 1)
    return [graded.count(dimension, degree) for degree in range(1, cap + 1)]


class DegreeSearch:
    """The loop over stops: each is fitted, measured and kept in the trace; the best is remembered."""

    def __init__(self, data: OrientedPoints, options: FitOptions, way: Fitter, judge: Judge) -> None:
        """Search on these data with this way to fit and this judge."""
        self.steps: list[Step] = []
        self.data, self.options, self.way = data, options, way
        self._judge = judge

    def run(self, alphas: Sequence[int], progress: Progress | None) -> Found:
        """Raise the number of columns until the judge has seen enough or nothing higher can be tried."""
        best: tuple[float, Fitted, Step, Closeness] | None = None
        some = self._determined(alphas)
        reason = self._judge.exhausted if len(some) == len(alphas) else StopReason.TOO_FEW_POINTS
        for group in self._groups(some, progress):
            tried = self._try(group)
            for fitted, step, at in tried:
                score = self._judge.score(step)
                if best is None or score < best[0]:
                    best = score, fitted, step, at
                self.steps.append(step)
                if progress is not None:
                    progress(step)
                verdict = self._judge.verdict(step, best[2])
                if verdict is not None:
                    return Found(best[1], best[2], best[3], verdict)
            if len(tried) < len(group):
                reason = StopReason.ILL_CONDITIONED
                break
        if best is None:
            raise ValueError("a search needs at least one stop")
        return Found(best[1], best[2], best[3], reason)

    def _determined(self, alphas: Sequence[int]) -> Sequence[int]:
        """Return the first stop, and those with no more columns than there are points."""
        most = max(self.data.count, self.data.points.shape[1] + 1)
        return [alpha for k, alpha in enumerate(alphas) if not k or alpha <= most]

    def _groups(self, alphas: Sequence[int], progress: Progress | None) -> Sequence[Sequence[int]]:
        """Return the stops in groups that are looked at together: one by one, unless nobody asks before the end."""
        if progress is None and self.options.criterion is Criterion.NONE and self.options.is_linear:
            return [alphas] if alphas else []
        return [[alpha] for alpha in alphas]

    def _try(self, alphas: Sequence[int]) -> list[tuple[Fitted, Step, Closeness]]:
        """Return the fits and what is noted and seen of them; fewer if not all of them can be had."""
        fits, seconds, started = [], [], perf_counter()
        for alpha in alphas:
            fitted = self.way.raise_to(alpha)
            if fitted is None:
                break
            fits.append(fitted)
            seconds.append(perf_counter() - started)
            started = perf_counter()
        if not fits:
            return []
        seen = closenesses([fitted.polynomial for fitted in fits], self.data, fits[0].weights)
        share = (perf_counter() - started) / len(fits)
        steps = [self._step(*each) for each in zip(fits, seen, [one + share for one in seconds], strict=True)]
        return list(zip(fits, steps, seen, strict=True))

    def _step(self, fitted: Fitted, at: Closeness, seconds: float) -> Step:
        asked = self.options.criterion is Criterion.BIC
        return Step(
            degree=fitted.polynomial.degree,
            columns=fitted.columns,
            dropped=fitted.dropped,
            d_dist=at.d_dist,
            d_smooth=at.d_smooth,
            rss=fitted.rss,
            gcv=criteria.gcv(fitted.rows, fitted.freedom, fitted.rss),
            condition=fitted.condition,
            seconds=seconds,
            ridged=fitted.ridged,
            bic=criteria.bic(fitted.rows, fitted.freedom, fitted.rss) if asked else None,
            loo=fitted.loo,
            diagonal_ratio=fitted.diagonal_ratio,
            iterations=fitted.iterations,
            quiet=fitted.quiet,
        )
