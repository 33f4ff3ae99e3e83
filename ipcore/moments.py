"""A point set as sums that add: it can be extended, merged and fitted again without its points."""

from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from pathlib import Path
from typing import IO, Self

import numpy as np
from numpy.typing import ArrayLike

from ipcore import _threads
from ipcore._threads import limited
from ipcore._typing import FloatArray
from ipcore.constraints.families import LAYERED_NAMES
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.linear.layer_moments import LayerMoments
from ipcore.linear.q_less import QLessFit
from ipcore.linear.row_source import MomentRows, RowSource, SummedRows
from ipcore.options.choices import Factor, integer
from ipcore.options.fit_options import HIGHEST_DEGREE, FitOptions
from ipcore.points import validation
from ipcore.points.digest import sha256
from ipcore.points.oriented import OrientedPoints
from ipcore.points.sample import Sample
from ipcore.points.stream import streamed
from ipcore.points.validation import PointSet
from ipcore.polynomial.frame import Frame
from ipcore.search.degree_search import DegreeSearch, Progress, stops
from ipcore.search.report import answer
from ipcore.search.result import FitResult
from ipcore.search.stopping import judge


@dataclass(frozen=True, eq=False)
class Moments:
    """The moments of a point set's layers (see `ipcore.linear.layer_moments`), with a sample of it.

    Attributes
    ----------
    frame
        The normalised frame. It stays that of the first points: moments in different frames do not add.
    layers
        The sums, in the frame.
    box
        (2, d), raw: lower and upper corner of all points.
    sample
        50,000 points at most, raw, with unit normals: what D_dist, D_smooth and stray are measured at.

    Examples
    --------
    >>> from ipcore import shapes
    >>> points, normals = shapes.torus().sample(2000)
    >>> first = Moments.of(points[:1500], normals[:1500], degree=6)
    >>> both = first.extended(points[1500:], normals[1500:])
    >>> both.count, both.fit().degree
    (2000, 4)

    """

    frame: Frame
    layers: LayerMoments
    box: FloatArray
    sample: Sample

    @classmethod
    def of(  # noqa: PLR0913 - of what, how far, where, and with what
        cls,
        points: ArrayLike,
        normals: ArrayLike,
        *,
        degree: int,
        options: FitOptions | None = None,
        frame: Frame | None = None,
        threads: int | None = None,
    ) -> Self:
        """Return the moments of points.

        Parameters
        ----------
        points, normals
            (N, d) each, raw; normals outward, of any length.
        degree
            The highest degree n that can be fitted. Size and time grow with the number of moments, C(2n + d, d).
        options
            `constraints`, 3l or 5l, and `layer_distance`; nothing else is used.
        frame
            The normalised frame; by default that of these points. Sets that will be merged need the same one. With it,
            points need not be a set that can be fitted: some of a set may well lie on one line.
        threads
            As for `ipcore.fit`.

        Raises
        ------
        InvalidPointsError, InvalidNormalsError, InvalidOptionsError
            If the points cannot be fitted, or the options ask for what is not a matter of moments.

        """
        offsets = (options or FitOptions()).layer_offsets
        if not offsets:
            raise InvalidOptionsError(f"moments are for constraints {LAYERED_NAMES}", ("constraints",))
        x = (
            validation.check(points).points
            if frame is None
            else validation.matrix("points", points, InvalidPointsError)
        )
        validation.check_shape(x.shape)
        integer("degree", degree, 1, HIGHEST_DEGREE[x.shape[1]])
        empty = LayerMoments.empty(x.shape[1], degree, offsets)
        start = cls(frame or Frame.of(x), empty, np.stack([x.min(axis=0), x.max(axis=0)]), Sample.empty(x.shape[1]))
        return start.extended(x, normals, threads=threads)

    @staticmethod
    def can_fit(options: FitOptions) -> bool:
        """Return whether moments give fits with these options.

        >>> Moments.can_fit(FitOptions(geometric=False)), Moments.can_fit(FitOptions())
        (True, False)
        """
        linear = options.is_linear and not options.needs_rows
        return linear and options.factor in {Factor.AUTO, Factor.MOMENTS} and bool(options.layer_offsets)

    @property
    def count(self) -> int:
        """Return N, the number of points."""
        return self.layers.count

    @property
    def degree(self) -> int:
        """Return the highest degree that can be fitted."""
        return self.layers.degree

    def extended(self, points: ArrayLike, normals: ArrayLike, *, threads: int | None = None) -> Self:
        """Return the moments of these points and more, (n, d) each, raw. The cost is that of the new ones alone.

        Raises
        ------
        InvalidPointsError, InvalidNormalsError
            If something is wrong with them.

        """
        x = validation.matrix("points", points, InvalidPointsError)
        if x.shape[1] != self.box.shape[1]:
            raise InvalidPointsError(f"points must have {self.box.shape[1]} columns, not {x.shape[1]}", ("points",))
        n = validation.unit(normals, x)
        if not len(x):
            return self
        box = np.stack([x.min(axis=0), x.max(axis=0)])
        with _threads.using(threads):
            layers = reduce(add, _threads.ordered(self._layers, ((x[s], n[s]) for s in _threads.slices(len(x)))))
        return self + Moments(self.frame, layers, box, Sample.of(x, n))

    def without_sample(self) -> Self:
        """Return the same without its sample, which is most of its bytes: enough for `fit` with the points at hand."""
        return replace(self, sample=Sample.empty(self.layers.dimension))

    def __add__(self, other: "Moments") -> Self:
        """Return the moments of both sets together.

        Raises
        ------
        InvalidOptionsError
            If frame, degree or layers are not the same.

        """
        same = np.array_equal(self.frame.centre, other.frame.centre) and self.frame.scale == other.frame.scale
        if not same or (self.degree, self.layers.offsets) != (other.degree, other.layers.offsets):
            raise InvalidOptionsError("moments add only in the same frame, up to the same degree, on the same layers")
        box = np.stack([np.minimum(self.box[0], other.box[0]), np.maximum(self.box[1], other.box[1])])
        return type(self)(self.frame, self.layers + other.layers, box, self.sample.with_more(other.sample))

    def fit(
        self,
        options: FitOptions | None = None,
        *,
        points: ArrayLike | PointSet | None = None,
        normals: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> FitResult:
        """Fit a polynomial whose degree finds itself, by default from the moments alone, in milliseconds.

        It is the linear fit of all points, D_dist within 1e-6 of itself, up to the degree where squaring the condition
        would show more: there the search ends as `ill-conditioned`. D_dist, D_smooth and what else is said of the data
        is measured at the sample, and the digest of the input is the sample's, too. With the points it is the fit of
        `ipcore.fit` in this frame, with nothing left out: only the pass over them that sums the moments is saved.

        Parameters
        ----------
        options
            See `FitOptions`; by default a linear fit. What moments cannot give is refused: sign constraints, the
            geometric fit, other factorisations, leaving points out.
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
            If the options ask for what moments cannot give, for other layers than they are of, or, without the points,
            for a higher degree.

        """
        asked = options or FitOptions(factor=Factor.MOMENTS)
        self._check(asked)
        top = asked.degree_cap(self.layers.dimension) if points is not None else self._reached(asked)
        data, source, digest = self._alone() if points is None else self._with(points, normals, asked)
        search = DegreeSearch(data, asked, QLessFit(data, asked, top, source), judge(asked))
        with limited(1):
            return answer(search, stops(self.layers.dimension, top, asked.granularity), progress, digest)

    def save(self, file: str | Path | IO[bytes]) -> None:
        """Write everything to an npz file."""
        np.savez(
            file,
            centre=self.frame.centre,
            scale=self.frame.scale,
            degree=self.degree,
            offsets=self.layers.offsets,
            count=self.count,
            sums=self.layers.sums,
            box=self.box,
            points=self.sample.points,
            normals=self.sample.normals,
        )

    @classmethod
    def load(cls, file: str | Path | IO[bytes]) -> Self:
        """Read what `save` wrote.

        Raises
        ------
        InvalidPointsError
            If it is something else.

        """
        try:
            with np.load(file, allow_pickle=False) as parts:
                frame = Frame(parts["centre"], float(parts["scale"]))
                offsets = tuple(parts["offsets"].tolist())
                layers = LayerMoments(int(parts["degree"]), offsets, int(parts["count"]), parts["sums"])
                return cls(frame, layers, parts["box"], Sample.of(parts["points"], parts["normals"]))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InvalidPointsError(f"not a file of moments: {error}") from error

    def _layers(self, piece: tuple[FloatArray, FloatArray]) -> LayerMoments:
        x, n = piece
        return LayerMoments.of(self.frame.to_local(x), n, self.degree, self.layers.offsets)

    def _check(self, options: FitOptions) -> None:
        """Refuse options that ask for what moments cannot give."""
        if not self.can_fit(options):
            raise InvalidOptionsError(
                "moments give linear fits only, with factor auto or moments and no point left out: set geometric to "
                "false, or fit the points themselves",
                ("geometric",),
            )
        if options.layer_offsets != self.layers.offsets:
            raise InvalidOptionsError(f"these are moments of layers at {self.layers.offsets}", ("layer_distance",))

    def _reached(self, options: FitOptions) -> int:
        """Return the last degree to try, if it is one that the moments reach and there are points to measure it at."""
        if (options.max_degree or 0) > self.degree:
            raise InvalidOptionsError(
                f"these moments reach up to degree {self.degree}, not {options.max_degree}", ("max_degree",)
            )
        if not len(self.sample.points):
            raise InvalidPointsError("these moments have no sample: they are fitted with their points", ("points",))
        return options.max_degree or self.degree

    def _alone(self) -> tuple[OrientedPoints, RowSource, str]:
        """Return the sample, the rows as far as moments tell of them, and the sample's digest."""
        data = OrientedPoints.sampled(self.sample, self.frame, self.box, self.count)
        return data, MomentRows(self.layers), sha256(self.sample.points, self.sample.normals)

    def _with(
        self, points: ArrayLike | PointSet, normals: ArrayLike | None, options: FitOptions
    ) -> tuple[OrientedPoints, RowSource, str]:
        """Return the points, their rows, and their digest."""
        given = streamed(points, normals) or validation.check(points, normals)
        if given.points.shape != (self.count, self.layers.dimension):
            raise InvalidPointsError(
                f"these are moments of {self.count} points, not of {len(given.points)}", ("points",)
            )
        data = OrientedPoints.of(given, options.neighbours, self.frame)
        return data, SummedRows(data, options, self.layers), given.sha256
