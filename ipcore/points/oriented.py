"""The data of a fit: points in the normalised frame, with unit outward normals and the bounds of the fit."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from ipcore._typing import FloatArray
from ipcore.points import winding
from ipcore.points.distinct import without_copies
from ipcore.points.normals import NormalSource, orient
from ipcore.points.outliers import without_outliers
from ipcore.points.outline import is_outline, outline_normals
from ipcore.points.sample import SAMPLE_SIZE, Sample
from ipcore.points.stream import PointStream
from ipcore.points.validation import PointSet, unit
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis

# The bounds of a fit are the data's box grown by this much on every side, in mean radii: room for the zero set to close
# around the data, and for the outer layers (layer_distance is at most this).
BOUNDS_MARGIN = 0.3
# Up to this share of copies, an outline meets itself in them: it gets its normals before copies are merged, for two of
# its curves may pass through one place. Of more copies, the outline itself is a copy.
MEETING_SHARE = 0.05
PART_POINTS = 8192  # points of a part, in passes over all points


class Part(Protocol):
    """Some of the points and their unit outward normals, (n, d) in the normalised frame."""

    @property
    def points(self) -> FloatArray:
        """Return the points (n, d)."""
        ...

    @property
    def normals(self) -> FloatArray:
        """Return the normals (n, d)."""
        ...


@dataclass(frozen=True, eq=False)
class HeldPart:
    """A part in memory: points and unit outward normals, (n, d) each, in the normalised frame."""

    points: FloatArray
    normals: FloatArray


class ReadPart:
    """A part as it was read: it is normalised when a thread first uses it, not by the thread that reads."""

    def __init__(self, frame: Frame, points: FloatArray, normals: FloatArray) -> None:
        """Take raw points and their normals, of any length but 0, (n, d) each."""
        self._frame, self._raw = frame, (points, normals)

    @cached_property
    def points(self) -> FloatArray:
        """Return the points (n, d) in the normalised frame."""
        return self._frame.to_local(self._raw[0])

    @cached_property
    def normals(self) -> FloatArray:
        """Return the unit normals (n, d)."""
        return unit(self._raw[1], self._raw[0])


@dataclass(frozen=True, eq=False)
class OrientedPoints:
    """Points and unit outward normals in the normalised frame.

    Attributes
    ----------
    points, normals
        (n, d), in the frame: all N points, or a sample of them if they are a stream.
    frame
        The normalised frame.
    bounds
        (2, d), in the frame: the box in which the fit is made.
    source
        Where the normals came from.
    planar
        Whether all points lie on one plane (3D).
    count
        N, the number of all points.
    stream
        The stream of all points, if `points` are a sample of them; else None.
    merged, outliers, incomplete
        How many of the caller's points are not among these: copies of others, outliers, and points with a missing
        value.

    """

    points: FloatArray
    normals: FloatArray
    frame: Frame
    bounds: FloatArray
    source: NormalSource
    planar: bool
    count: int
    stream: PointStream | None = None
    merged: int = 0
    outliers: int = 0
    incomplete: int = 0

    @classmethod
    def prepared(cls, given: PointSet | PointStream, neighbours: int, *, robust: bool) -> Self:
        """Return points as `of` does, but of copies only one, and without outliers if the fit is `robust`.

        Of a stream nothing is left out. `neighbours` is as for `of`.
        """
        if isinstance(given, PointStream):
            return cls.of(given, neighbours)
        distinct, merged = without_copies(given)
        if not robust and 0 < merged <= MEETING_SHARE * len(given.points) and _runs_along_curves(given):
            along = replace(given, normals=outline_normals(given.points))
            distinct, merged = without_copies(along)
            found = replace(cls.of(distinct, neighbours), source=NormalSource.OUTLINE)
            return replace(found, merged=merged, incomplete=given.incomplete)
        left, outliers = without_outliers(distinct) if robust else (distinct, 0)
        return replace(cls.of(left, neighbours), merged=merged, outliers=outliers, incomplete=given.incomplete)

    @classmethod
    def of(cls, given: PointSet | PointStream, neighbours: int, frame: Frame | None = None) -> Self:
        """Return points in the normalised frame, with normals, which are estimated if none were given.

        Parameters
        ----------
        given
            The caller's points. Of a stream, only the sample is held.
        neighbours
            How many neighbours each normal is estimated from.
        frame
            The normalised frame; by default that of the points.

        """
        if isinstance(given, PointStream):
            held = cls.sampled(given.sample, frame or given.frame, given.box, given.count)
            return replace(held, planar=given.planar, stream=given)
        frame = frame or given.frame
        x = frame.to_local(given.points)
        normals, source = (given.normals, NormalSource.GIVEN) if given.normals is not None else orient(x, neighbours)
        bounds = _grown(np.stack([x.min(axis=0), x.max(axis=0)]))
        return cls(x, normals, frame, bounds, source, given.planar, len(x))

    @classmethod
    def sampled(cls, sample: Sample, frame: Frame, box: FloatArray, count: int) -> Self:
        """Return a sample, raw, of `count` points that lie in a box (2, d), raw, in the normalised frame."""
        x, bounds = frame.to_local(sample.points), _grown(frame.to_local(box))
        return cls(x, sample.normals, frame, bounds, NormalSource.GIVEN, planar=False, count=count)

    def parts(self) -> Iterable[Part]:
        """Return all points in parts, in order: slices of those in memory, or pieces read from the stream."""
        if self.stream is not None:
            return (ReadPart(self.frame, x, n) for x, n in self.stream.pieces())
        return self.held_parts()

    def held_parts(self) -> list[HeldPart]:
        """Return the points that are in memory in parts, in order."""
        starts = range(0, len(self.points), PART_POINTS)
        return [
            HeldPart(self.points[start : start + PART_POINTS], self.normals[start : start + PART_POINTS])
            for start in starts
        ]

    @cached_property
    def thinned(self) -> "OrientedPoints":
        """Return at most `SAMPLE_SIZE` of the points, in memory: enough for what does not need all of them."""
        if self.stream is None and self.count <= SAMPLE_SIZE:
            return self
        sample = Sample.of(self.points, self.normals)
        return replace(self, points=sample.points, normals=sample.normals, count=len(sample.points), stream=None)

    def polynomial(self, degree: int, coefficients: FloatArray, basis: Basis) -> ImplicitPolynomial:
        """Return the polynomial with these coefficients (≤ m,) in this basis, in the normalised frame.

        Coefficients that are missing at the end are 0.
        """
        frame = Frame(np.zeros(self.points.shape[1]), 1.0)
        a = np.zeros(graded.count(self.points.shape[1], degree))
        a[: len(coefficients)] = coefficients
        return ImplicitPolynomial(degree, a, frame, self.bounds, basis)

    def to_raw(self, polynomial: ImplicitPolynomial) -> ImplicitPolynomial:
        """Return a polynomial of the normalised frame in raw coordinates; its coefficients do not change."""
        bounds = self.frame.to_raw(polynomial.bounds)
        return replace(polynomial, frame=self.frame, bounds=bounds)

    def self_check(self) -> float:
        """Return the share of points whose normals agree with the winding number, see `winding.self_check`."""
        return winding.self_check(self.points, self.normals)


def _runs_along_curves(given: PointSet) -> bool:
    """Return whether points without normals run along an outline, whose order then gives the normals."""
    return given.normals is None and given.points.shape[1] == 2 and is_outline(given.points)


def _grown(box: FloatArray) -> FloatArray:
    """Return a box (2, d) grown by `BOUNDS_MARGIN` on every side."""
    return np.asarray(box + np.array([[-BOUNDS_MARGIN], [BOUNDS_MARGIN]]))
