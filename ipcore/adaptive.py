"""The two ways in: a fit whose degree finds itself (the paper's section 4), and a fit of a degree that is known."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import version

from numpy.typing import ArrayLike

from ipcore import monomials
from ipcore import points as pointset
from ipcore.choices import Constraints, Criterion, Granularity, chosen
from ipcore.errors import InvalidOptionsError
from ipcore.judges import Judge, LastJudge, judge
from ipcore.linear import prefix_fit
from ipcore.options import HIGHEST_DEGREE, FitOptions
from ipcore.oriented import OrientedPoints, sha256
from ipcore.points import PointSet
from ipcore.prefix import PrefixFit
from ipcore.quiet import QuietFit
from ipcore.ranges import integer
from ipcore.report import diagnose
from ipcore.result import FitResult, StopReason
from ipcore.search import DegreeSearch, Progress, stops


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
    dimension = given.points.shape[1]
    cap = options.degree_cap(dimension)
    if given.planar:
        return _searched(given, options, stops(dimension, 1, Granularity.FORM), LastJudge(StopReason.PLANAR), progress)
    return _searched(given, options, stops(dimension, cap, options.granularity), judge(options), progress)


def fit_fixed(
    points: ArrayLike,
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
    given = pointset.check(points, normals)
    count, dimension = given.points.shape
    integer("degree", degree, 1, HIGHEST_DEGREE[dimension])
    columns = monomials.count(dimension, degree)
    if columns > count:
        raise InvalidOptionsError(
            f"degree {degree} has {columns} coefficients, more than {count} points determine", ("degree",)
        )
    options = options or FitOptions()
    options = replace(options, max_degree=degree, criterion=Criterion.NONE)
    if method is not None:
        family = chosen("method", method, Constraints)
        options = replace(options, constraints=family, signs=False, geometric=False)
    return _searched(given, options, [columns], LastJudge(), None)


def _searched(
    given: PointSet, options: FitOptions, alphas: Sequence[int], by: Judge, progress: Progress | None
) -> FitResult:
    """Orient the points, search over these stops, and report."""
    data = OrientedPoints.of(given, options.neighbours)
    top = monomials.degree_of(data.points.shape[1], alphas[-1])
    how = _way(data, options, top)
    search = DegreeSearch(data, options, how, by)
    found = search.run(alphas, progress)
    loss = how.orthogonality_loss(found.step.columns)
    diagnosis = diagnose(found.fitted, data, options, found.reason, loss)
    return FitResult(
        diagnosis.polynomial,
        found.reason,
        tuple(search.steps),
        diagnosis.diagnostics,
        diagnosis.warnings,
        options,
        _version(),
        sha256(given),
    )


@cache
def _version() -> str:
    """Return the library's version; to read it takes as long as a small fit's zero set."""
    return version("ipfit")


def _way(data: OrientedPoints, options: FitOptions, top: int) -> PrefixFit:
    """Return the way to fit that the options ask for, up to the degree `top`."""
    linear = options.is_linear or data.planar
    return prefix_fit(data, options, top) if linear else QuietFit(data, options, top)
