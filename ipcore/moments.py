"""Fits from moments: a point set can be extended, merged and fitted again without its points."""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from ipcore._threads import limited
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.linear.q_less import QLessFit
from ipcore.linear.row_source import MomentRows, RowSource, SummedRows
from ipcore.linear.summed_points import SummedPoints
from ipcore.options.choices import Factor
from ipcore.options.fit_options import FitOptions
from ipcore.points import validation
from ipcore.points.digest import sha256
from ipcore.points.oriented import OrientedPoints
from ipcore.points.stream import streamed
from ipcore.points.validation import PointSet
from ipcore.search.criteria import stopping_criterion
from ipcore.search.degree_search import DegreeSearch, Progress, column_counts
from ipcore.search.report import fit_result
from ipcore.search.result import FitResult

# The options of `Moments.fit` unless others are given: those of `FitOptions()`, but a linear fit. `ipcore.fit`, whose
# default is the geometric fit, gives another polynomial for the same points.
DEFAULT_MOMENT_OPTIONS = FitOptions(factor=Factor.MOMENTS)


@dataclass(frozen=True, eq=False)
class Moments(SummedPoints):
    """The moments of a point set's layers (see `ipcore.linear.layer_moments`), with a sample of its points.

    Attributes
    ----------
    frame
        The normalised frame. It stays that of the first points: moments in different frames do not add.
    layers
        The moments, in the frame.
    box
        (2, d), raw: lower and upper corner of all points.
    sample
        50,000 points at most, raw, with unit normals: D_dist, D_smooth and stray are measured at them.

    Examples
    --------
    >>> from ipcore import shapes
    >>> points, normals = shapes.torus().sample(2000)
    >>> first = Moments.of(points[:1500], normals[:1500], degree=6)
    >>> both = first.extended(points[1500:], normals[1500:])
    >>> both.count, both.fit().degree
    (2000, 4)

    """

    @staticmethod
    def can_fit(options: FitOptions) -> bool:
        """Return whether fits with these options can be made from moments.

        >>> Moments.can_fit(FitOptions(geometric=False)), Moments.can_fit(FitOptions())
        (True, False)
        """
        return options.fits_from_moments

    def fit(
        self,
        options: FitOptions | None = None,
        *,
        points: ArrayLike | PointSet | None = None,
        normals: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> FitResult:
        """Fit a polynomial and find its degree, from the moments alone unless the points are given.

        From moments alone it takes milliseconds, and gives the linear fit of all points; D_dist is within 1e-6 of
        itself. The search ends as `ill-conditioned` at the degree where squaring the condition would show more. D_dist,
        D_smooth and all other figures of the data are measured at the sample, and the digest of the input is that of
        the sample. With the points, it gives the fit of `ipcore.fit` with the same options in this frame, and saves the
        pass over them that sums the moments.

        Parameters
        ----------
        options
            See `FitOptions`. By default `FitOptions(factor="moments")`: all defaults of `FitOptions`, but a linear fit.
            Without the points, `max_degree` is by default the highest degree of the moments. Options that moments
            cannot give are refused: sign constraints, the geometric fit, other factorisations, the criterion loo.
        points, normals
            The points of which these are the moments, (N, d) each, held or memory-mapped, if they are still at hand.
            Degrees that the moments do not reach are then fitted from the points.
        progress
            As for `ipcore.fit`.

        Raises
        ------
        InvalidPointsError, InvalidNormalsError
            If the points cannot be fitted, or are not as many as these moments are of.
        InvalidOptionsError
            If the options need more than moments, or other layers than these, or, without the points, a higher degree.

        """
        options = options or DEFAULT_MOMENT_OPTIONS
        self._check(options)
        dimension = self.layers.dimension
        max_degree = options.degree_cap(dimension) if points is not None else self._max_degree(options)
        data, source, digest = self._without_points() if points is None else self._with(points, normals, options)
        fitter = QLessFit(data, options, max_degree, source)
        search = DegreeSearch(data, options, fitter, stopping_criterion(options))
        with limited(1):
            best, reason = search.run(column_counts(dimension, max_degree, options.granularity), progress)
            return fit_result(search, best, reason, digest)

    def _check(self, options: FitOptions) -> None:
        """Check that the options need no more than moments, and the layers of these."""
        if not self.can_fit(options):
            raise InvalidOptionsError(
                "moments give linear fits only, with factor auto or moments and no point left out: set geometric to "
                "false, or fit the points themselves",
                ("geometric",),
            )
        if options.layer_offsets != self.layers.offsets:
            raise InvalidOptionsError(f"these are moments of layers at {self.layers.offsets}", ("layer_distance",))

    def _max_degree(self, options: FitOptions) -> int:
        """Return the last degree to try without the points; check that the moments reach it and there is a sample."""
        if (options.max_degree or 0) > self.degree:
            raise InvalidOptionsError(
                f"these moments reach up to degree {self.degree}, not {options.max_degree}", ("max_degree",)
            )
        if not len(self.sample.points):
            raise InvalidPointsError("these moments have no sample: they are fitted with their points", ("points",))
        return options.max_degree or self.degree

    def _without_points(self) -> tuple[OrientedPoints, RowSource, str]:
        """Return the sample, the rows as far as moments give them, and the digest of the sample."""
        data = OrientedPoints.sampled(self.sample, self.frame, self.box, self.count)
        return data, MomentRows(self.layers), sha256(self.sample.points, self.sample.normals)

    def _with(
        self, points: ArrayLike | PointSet, normals: ArrayLike | None, options: FitOptions
    ) -> tuple[OrientedPoints, RowSource, str]:
        """Return the points in the frame, their rows, and their digest."""
        checked = streamed(points, normals) or validation.check(points, normals)
        if checked.points.shape != (self.count, self.layers.dimension):
            raise InvalidPointsError(
                f"these are moments of {self.count} points, not of {len(checked.points)}", ("points",)
            )
        data = OrientedPoints.of(checked, options.neighbours, self.frame)
        return data, SummedRows(data, options, self.layers), checked.sha256
