"""The two ways in: a fit whose degree finds itself (the paper's section 4), and a fit of a degree that is known."""

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from ipcore._threads import limited, using
from ipcore.constraints.families import Constraints
from ipcore.errors import InvalidOptionsError
from ipcore.geometric.fit import GeometricFit
from ipcore.linear.dense import LeastSquaresFit, TaubinFit
from ipcore.linear.q_less import QLessFit
from ipcore.linear.row_source import DataRows
from ipcore.options.choices import Criterion, Factor, Granularity, chosen, integer
from ipcore.options.fit_options import HIGHEST_DEGREE, FitOptions
from ipcore.points import validation
from ipcore.points.oriented import OrientedPoints
from ipcore.points.stream import PointStream, spooled, streamed
from ipcore.points.validation import PointSet
from ipcore.polynomial import graded
from ipcore.search.degree_search import DegreeSearch, Progress, stops
from ipcore.search.fitter import Fitter
from ipcore.search.report import answer
from ipcore.search.result import FitResult, StopReason
from ipcore.search.stopping import Judge, LastJudge, judge


def fit(
    points: ArrayLike | PointSet | Iterator[Any],
    normals: ArrayLike | None = None,
    options: FitOptions | None = None,
    *,
    progress: Progress | None = None,
    threads: int | None = None,
) -> FitResult:
    """Fit an implicit polynomial whose degree finds itself.

    Parameters
    ----------
    points
        (N, 2) or (N, 3), raw coordinates. A memory-mapped array of 2¹⁸ points or more, with normals, is streamed: read
        piece by piece, as often as needed, in constant memory. So is an iterator of pairs (points, normals), which is
        written to a temporary file first. Of a stream, linear fits and D_dist, D_smooth and the maximum count every
        point; the geometric fit and all other figures are those of a sample of 50,000.
    normals
        (N, d), outward, of any length. Without them: from the order of a 2D outline, else estimated and oriented.
    options
        See `FitOptions`.
    progress
        Called with every `Step` as it is made; what it raises ends the fit and reaches the caller.
    threads
        How many to work with, at most; by default OMP_NUM_THREADS if set, else all cores. They change nothing beyond
        rounding. Those of BLAS are limited for the whole process meanwhile.

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
    with using(threads):
        given = _given(points, normals)
        dimension = given.points.shape[1]
        cap = options.degree_cap(dimension)
        if given.planar:
            alphas = stops(dimension, 1, Granularity.FORM)
            return _searched(given, options, alphas, LastJudge(StopReason.PLANAR), progress)
        return _searched(given, options, stops(dimension, cap, options.granularity), judge(options), progress)


def fit_fixed(
    points: ArrayLike | PointSet,
    normals: ArrayLike | None = None,
    options: FitOptions | None = None,
    *,
    degree: int,
    method: Constraints | str | None = None,
) -> FitResult:
    """Fit an implicit polynomial of a given degree, by any of the constraint families.

    Parameters
    ----------
    points, normals
        As for `fit`.
    options
        See `FitOptions`; what concerns the search is not used.
    degree
        The total degree n: 1 … 40 in 2D, 1 … 20 in 3D.
    method
        The constraint family of a linear fit, in place of what the options ask for.

    Raises
    ------
    InvalidPointsError, InvalidNormalsError, InvalidOptionsError
        If the input cannot be fitted, or the degree has more coefficients than there are points.

    Examples
    --------
    >>> from ipcore import shapes
    >>> result = fit_fixed(*shapes.ellipse().sample(100), degree=2, method="taubin")
    >>> bool(result.diagnostics.distance_max < 1e-12), str(result.stop_reason)
    (True, 'degree-reached')

    """
    given = _given(points, normals)
    count, dimension = given.points.shape
    integer("degree", degree, 1, HIGHEST_DEGREE[dimension])
    columns = graded.count(dimension, degree)
    if columns > count:
        raise InvalidOptionsError(
            f"degree {degree} has {columns} coefficients, more than {count} points determine", ("degree",)
        )
    options = replace(options or FitOptions(), max_degree=degree, criterion=Criterion.NONE)
    if method is not None:
        family = chosen("method", method, Constraints)
        options = replace(options, constraints=family, signs=False, geometric=False)
    return _searched(given, options, [columns], LastJudge(), None)


def _given(points: ArrayLike | PointSet | Iterator[Any], normals: ArrayLike | None) -> PointSet | PointStream:
    """Return what is to be fitted, checked."""
    if isinstance(points, Iterator):
        return spooled(points, normals)
    return streamed(points, normals) or validation.check(points, normals)


def _searched(
    given: PointSet | PointStream, options: FitOptions, alphas: Sequence[int], by: Judge, progress: Progress | None
) -> FitResult:
    """Orient the points, choose the way to fit, and search over these stops."""
    data = OrientedPoints.of(given, options.neighbours)
    how = way(data, options, graded.degree_of(data.points.shape[1], alphas[-1]))
    # all of M is worth BLAS's threads; elsewhere ours do more, and BLAS's would wait for each other
    with nullcontext() if isinstance(how, LeastSquaresFit) else limited(1):
        return answer(DegreeSearch(data, options, how, by), alphas, progress, given.sha256)


def way(data: OrientedPoints, options: FitOptions, top: int) -> Fitter:
    """Return the way to fit, up to the degree `top`."""
    if options.is_linear or data.planar:
        return linear(data, options, top)
    return GeometricFit(data if options.robust else data.thinned, options, top)


def linear(data: OrientedPoints, options: FitOptions, top: int) -> Fitter:
    """Return the linear way."""
    if not options.family.is_least_squares:
        return TaubinFit(data, options, top)
    if options.factor in {Factor.BLOCK, Factor.GRAM_SCHMIDT} or options.needs_rows:
        return LeastSquaresFit(data, options, top)
    return QLessFit(data, options, top, DataRows(data, options))
