"""The adaptive fit: raise the degree until the fit is close and smooth enough (the paper's section 4)."""

from collections.abc import Callable
from importlib.metadata import version
from time import perf_counter

from numpy.typing import ArrayLike

from ipcore import monomials
from ipcore import points as pointset
from ipcore.criteria import Closeness, StoppingRule
from ipcore.linear import LinearFit
from ipcore.options import FitOptions
from ipcore.oriented import OrientedPoints, sha256
from ipcore.report import diagnose
from ipcore.result import FitResult, Step, StopReason

Progress = Callable[[Step], None]


def fit(
    points: ArrayLike,
    normals: ArrayLike | None = None,
    options: FitOptions | None = None,
    *,
    progress: Progress | None = None,
) -> FitResult:
    """Fit an implicit polynomial whose degree finds itself.

    Parameters
    ----------
    points
        (N, 2) or (N, 3), raw coordinates.
    normals
        (N, d), outward, of any length. Without them: from the order of a 2D outline, else estimated and oriented.
    options
        See `FitOptions`.
    progress
        Called with every `Step` as it is made; what it raises ends the fit and reaches the caller.

    Raises
    ------
    InvalidPointsError, InvalidNormalsError, InvalidOptionsError
        If the input cannot be fitted; the message says why and `at` says where.

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    >>> result = fit(np.stack([3.0 * np.cos(angle), 2.0 * np.sin(angle)], axis=1))
    >>> result.degree, str(result.stop_reason)
    (2, 'criterion-met')
    >>> result.polynomial(np.array([[0.0, 0.0], [4.0, 0.0]])) > 0.0       # inside, outside
    array([False,  True])

    """
    options = options or FitOptions()
    given = pointset.check(points, normals)
    cap = options.degree_cap(given.points.shape[1])
    data = OrientedPoints.of(given, options.neighbours)
    search = _Search(data, options, cap)
    reason = search.run(progress)
    diagnosis = diagnose(search.best, data, options, reason)
    return FitResult(
        diagnosis.polynomial,
        reason,
        tuple(search.steps),
        diagnosis.diagnostics,
        diagnosis.warnings,
        options,
        version("ipfit"),
        sha256(given),
    )


class _Search:
    """The loop over degrees: every one is fitted, measured and kept in the trace; the best is remembered."""

    def __init__(self, data: OrientedPoints, options: FitOptions, cap: int) -> None:
        self.steps: list[Step] = []
        self._data = data
        self._cap = 1 if data.planar else cap
        self._rule = StoppingRule(options.t1, options.t2)
        self._linear = LinearFit(data, options, self._cap)
        self._least = float("inf")

    def run(self, progress: Progress | None) -> StopReason:
        """Raise the degree until the stopping rule is met or nothing higher can be tried, and return which."""
        count, dimension = self._data.points.shape
        for degree in range(1, self._cap + 1):
            if monomials.count(dimension, degree) > max(count, dimension + 1):
                return StopReason.TOO_FEW_POINTS
            step = self._try(degree)
            if progress is not None:
                progress(step)
            if self._data.planar:
                return StopReason.PLANAR
            if self._rule.met(step.d_dist, step.d_smooth):
                return StopReason.CRITERION_MET
        return StopReason.MAX_DEGREE

    def _try(self, degree: int) -> Step:
        started = perf_counter()
        linear = self._linear.raise_to(degree)
        candidate = self._data.polynomial(degree, linear.coefficients)
        at = Closeness.of(*candidate.value_and_gradient(self._data.points), self._data.normals)
        excess = self._rule.excess(at.d_dist, at.d_smooth)
        if excess < self._least:
            self._least, self.best = excess, candidate
        step = Step(
            degree,
            linear.columns,
            linear.dropped,
            at.d_dist,
            at.d_smooth,
            linear.rss,
            linear.gcv,
            linear.condition,
            perf_counter() - started,
        )
        self.steps.append(step)
        return step
