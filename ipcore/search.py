"""The search for the degree: fit, measure, judge, go on (the paper's section 4.3).

What fits at each stop and what judges the fits are plugged in; the loop is written once.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

from ipcore import criteria, monomials
from ipcore.choices import Criterion, Granularity
from ipcore.closeness import closeness
from ipcore.criteria import Closeness
from ipcore.judges import Judge
from ipcore.options import FitOptions
from ipcore.oriented import OrientedPoints
from ipcore.prefix import Fitted, PrefixFit
from ipcore.result import Step, StopReason

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
        return range(2, monomials.count(dimension, cap) + 1)
    return [monomials.count(dimension, degree) for degree in range(1, cap + 1)]


class DegreeSearch:
    """The loop over stops: each is fitted, measured and kept in the trace; the best is remembered."""

    def __init__(self, data: OrientedPoints, options: FitOptions, way: PrefixFit, judge: Judge) -> None:
        """Search on these data with this way to fit and this judge."""
        self.steps: list[Step] = []
        self.data, self.options, self.way = data, options, way
        self._judge = judge

    def run(self, alphas: Sequence[int], progress: Progress | None) -> Found:
        """Raise the number of columns until the judge has seen enough or nothing higher can be tried."""
        count, dimension = self.data.count, self.data.points.shape[1]
        best: tuple[float, Fitted, Step, Closeness] | None = None
        reason = self._judge.exhausted
        for alpha in alphas:
            if best is not None and alpha > max(count, dimension + 1):
                reason = StopReason.TOO_FEW_POINTS
                break
            tried = self._try(alpha)
            if tried is None:
                reason = StopReason.ILL_CONDITIONED
                break
            fitted, step, at = tried
            score = self._judge.score(step)
            if best is None or score < best[0]:
                best = score, fitted, step, at
            if progress is not None:
                progress(step)
            verdict = self._judge.verdict(step, best[2])
            if verdict is not None:
                reason = verdict
                break
        if best is None:
            raise ValueError("a search needs at least one stop")
        return Found(best[1], best[2], best[3], reason)

    def _try(self, alpha: int) -> tuple[Fitted, Step, Closeness] | None:
        """Return the fit and what is noted and seen of it; None if there is none with so many columns."""
        started = perf_counter()
        fitted = self.way.raise_to(alpha)
        if fitted is None:
            return None
        at = closeness(fitted.polynomial, self.data, fitted.weights)
        step = self._step(fitted, at, started)
        self.steps.append(step)
        return fitted, step, at

    def _step(self, fitted: Fitted, at: Closeness, started: float) -> Step:
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
            seconds=perf_counter() - started,
            ridged=fitted.ridged,
            bic=criteria.bic(fitted.rows, fitted.freedom, fitted.rss) if asked else None,
            loo=fitted.loo,
            diagonal_ratio=fitted.diagonal_ratio,
            iterations=fitted.iterations,
            quiet=fitted.quiet,
        )
