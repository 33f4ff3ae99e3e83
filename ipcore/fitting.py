"""The two functions that fit: `fit` finds the degree itself (the paper's section 4), `fit_fixed` is given it."""

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from ipcore._threads import limited, using
from ipcore.constraints.registry import Constraints
from ipcore.errors import InvalidOptionsError
from ipcore.geometric.fit import GeometricFit
from ipcore.linear.dense import DenseFit
from ipcore.linear.q_less import QLessFit
from ipcore.linear.row_source import DataRows
from ipcore.linear.taubin import TaubinFit
from ipcore.options.choices import Criterion, Granularity, member
from ipcore.options.degrees import HIGHEST_DEGREE
from ipcore.options.fit_options import FitOptions
from ipcore.options.ranges import check_integer
from ipcore.points import validation
from ipcore.points.oriented import OrientedPoints
from ipcore.points.stream import PointStream, spooled, streamed
from ipcore.points.validation import PointSet
from ipcore.polynomial import graded
from ipcore.search.criteria import stopping_criterion
from ipcore.search.degree_search import DegreeSearch, Progress, column_counts
from ipcore.search.fitter import Fitter
from ipcore.search.report import fit_result
from ipcore.search.result import FitResult
from ipcore.search.stop_reason import StopReason
from ipcore.search.stopping_rule import StoppingRule


def fit(
    points: ArrayLike | PointSet | Iterator[Any],
    normals: ArrayLike | None = None,
    options: FitOptions | None = None,
    *,
    progress: Progress | None = None,
    threads: int | None = None,
) -> FitResult:
    """Fit an implicit polynomial, and find its degree.

    Parameters
    ----------
    points
        (N, 2) or (N, 3), raw coordinates. A memory-mapped array of 2¹⁸ points or more, with normals, is streamed: read
        piece by piece, as often as needed, in constant memory. So is an iterator of pairs (points, normals), which is
        written to a temporary file first. For a stream, linear fits and D_dist, D_smooth and the maximum are over all
        points; the geometric fit and all other figures are those of a sample of 50,000.
    normals
        (N, d), outward, of any length. Without them, normals come from the order of the points if they are a 2D
        outline, and are estimated and oriented otherwise.
    options
        See `FitOptions`.
    progress
        Called with every `Step` as it is made. An exception that it raises ends the fit and reaches the caller.
    threads
        The number of threads at most; by default OMP_NUM_THREADS if set, else the number of cores. It changes results
        by rounding only. While the fit runs, BLAS is limited to this number too, in the whole process.

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
        checked = _checked(points, normals)
        options.degree_cap(checked.points.shape[1])  # a max_degree that is too high is refused before the work
        return _search(checked, _prepared(checked, options), options, progress)


def fit_fixed(  # noqa: PLR0913 - those of `fit`, and two of its own
    points: ArrayLike | PointSet,
    normals: ArrayLike | None = None,
    options: FitOptions | None = None,
    *,
    degree: int,
    method: Constraints | str | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> FitResult:
    """Fit an implicit polynomial of a given degree.

    Parameters
    ----------
    points, normals
        As for `fit`.
    options
        See `FitOptions`; `max_degree` and `criterion` are not used.
    degree
        The total degree n: 1 … 40 in 2D, 1 … 20 in 3D.
    method
        The constraint family of a linear fit, in place of `constraints`, `signs` and `geometric` of the options.
    progress, threads
        As for `fit`.

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
    with using(threads):
        checked = _checked(points, normals)
        dimension = checked.points.shape[1]
        check_integer("degree", degree, 1, HIGHEST_DEGREE[dimension])
        options = replace(options or FitOptions(), max_degree=degree, criterion=Criterion.NONE)
        data, columns = _prepared(checked, options), graded.count(dimension, degree)
        if columns - 1 > data.count:
            raise InvalidOptionsError(
                f"degree {degree} has {columns} coefficients, more than {data.count} points determine", ("degree",)
            )
        if method is not None:
            family = member("method", method, Constraints)
            options = replace(options, constraints=family, signs=False, geometric=False)
        return _search(checked, data, options, progress, [columns])


def _checked(points: ArrayLike | PointSet | Iterator[Any], normals: ArrayLike | None) -> PointSet | PointStream:
    """Return the points and normals, checked: held, or as a stream."""
    if isinstance(points, Iterator):
        return spooled(points, normals)
    return streamed(points, normals) or validation.check(points, normals)


def _prepared(checked: PointSet | PointStream, options: FitOptions) -> OrientedPoints:
    """Return the points as they are fitted: with normals, of copies only one, in a robust fit without outliers."""
    return OrientedPoints.prepared(checked, options.neighbours, robust=options.robust)


def _search(
    checked: PointSet | PointStream,
    data: OrientedPoints,
    options: FitOptions,
    progress: Progress | None,
    alphas: Sequence[int] | None = None,
) -> FitResult:
    """Search over these numbers of columns α, by default over all degrees that the options allow.

    `data` are the points of `checked` as they are fitted. A plane needs, and determines, degree 1 only.
    """
    d, known_reason = data.points.shape[1], None
    if alphas is None:
        alphas = column_counts(d, options.degree_cap(d), options.granularity)
        if data.planar:
            alphas, known_reason = column_counts(d, 1, Granularity.FORM), StopReason.PLANAR
    criterion = stopping_criterion(options)
    fitter = choose_fitter(data, options, graded.degree_of(d, alphas[-1]), criterion.rule)
    # Only a fit that holds all of M gains from BLAS's threads. Other fits run threads of their own, with one BLAS
    # thread in each: more would wait for each other.
    with nullcontext() if isinstance(fitter, DenseFit) else limited(1):
        search = DegreeSearch(data, options, fitter, criterion)
        best, reason = search.run(alphas, progress)
        return fit_result(search, best, known_reason or reason, checked.sha256)


def choose_fitter(data: OrientedPoints, options: FitOptions, max_degree: int, rule: StoppingRule) -> Fitter:
    """Return the method of fitting that the options ask for, for degrees up to `max_degree`."""
    if options.is_linear or data.planar:
        return choose_linear_fitter(data, options, max_degree)
    return GeometricFit(data if options.robust else data.thinned, options, max_degree, rule)


def choose_linear_fitter(data: OrientedPoints, options: FitOptions, max_degree: int) -> Fitter:
    """Return the linear method of fitting that the options ask for, for degrees up to `max_degree`."""
    if not options.family.is_least_squares:
        return TaubinFit(data, options, max_degree)
    if options.holds_design_matrix:
        return DenseFit(data, options, max_degree)
    return QLessFit(data, options, max_degree, DataRows(data, options))
