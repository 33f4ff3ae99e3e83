"""The data as the fit sees it: normalised, oriented, boxed."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from ipcore._typing import FloatArray
from ipcore.points import winding
from ipcore.points.normals import NormalSource, orient
from ipcore.points.sample import SIZE, Sample
from ipcore.points.stream import PointStream
from ipcore.points.validation import PointSet, unit
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis

# The fit's bounds are the data's box grown by this much on every side, in mean radii: room for the zero set to close
# round the data, and for the outer layers (layer_distance is at most this).
MARGIN = 0.3


PART = 8192  # points at once in passes over all of them


class Part(Protocol):
    """Some of the points and their unit outward normals, (n, d) in the normalised frame."""

    @property
    def points(self) -> FloatArray:
        """Return the points."""
        ...

    @property
    def normals(self) -> FloatArray:
        """Return the normals."""
        ...


@dataclass(frozen=True, eq=False)
class HeldPart:
    """A part that is there."""

    points: FloatArray
    normals: FloatArray


class ReadPart:
    """A part as it was read: normalised by the thread that asks for it, not by the one that reads."""

    def __init__(self, frame: Frame, points: FloatArray, normals: FloatArray) -> None:
        """Take raw points and normals of any length but 0, (n, d) each."""
        self._frame, self._raw = frame, (points, normals)

    @cached_property
    def points(self) -> FloatArray:
        """Return the points."""
        return self._frame.to_local(self._raw[0])

    @cached_property
    def normals(self) -> FloatArray:
        """Return the normals."""
        return unit(self._raw[1], self._raw[0])


@dataclass(frozen=True, eq=False)
class OrientedPoints:
    """Points and unit outward normals in the normalised frame.

    Attributes
    ----------
    points, normals
        (N, d), in the frame. Of a stream, a sample.
    frame
        From raw coordinates and back.
    bounds
        (2, d), in the frame: the box in which the fit is made.
    source
        Where the normals came from.
    planar
        Whether all points lie on one plane (3D).
    count
        N, the number of all points: more than those here, if these are a sample.
    stream
        Where all points can be read, if these are a sample.

    """

    points: FloatArray
    normals: FloatArray
    frame: Frame
    bounds: FloatArray
    source: NormalSource
    planar: bool
    count: int
    stream: PointStream | None = None

    @classmethod
    def of(cls, given: PointSet | PointStream, neighbours: int, frame: Frame | None = None) -> Self:
        """Normalise, by default to the points' own frame, and orient if the caller gave no normals.

        Of a stream, only the sample is held.
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
        """Take a sample of so many points in a box (2, d), raw."""
        x, bounds = frame.to_local(sample.points), _grown(frame.to_local(box))
        return cls(x, sample.normals, frame, bounds, NormalSource.GIVEN, planar=False, count=count)

    def parts(self) -> Iterable[Part]:
        """Return all points in parts, in order: views of those that are held, or pieces read from the stream."""
        if self.stream is not None:
            return (ReadPart(self.frame, x, n) for x, n in self.stream.pieces())
        return self.held_parts()

    def held_parts(self) -> list[HeldPart]:
        """Return the points that are held in parts, in order."""
        starts = range(0, len(self.points), PART)
        return [HeldPart(self.points[start : start + PART], self.normals[start : start + PART]) for start in starts]

    @cached_property
    def thinned(self) -> "OrientedPoints":
        """Return the same with `SIZE` points at most, held: enough for what does not need all of them."""
        if self.stream is None and self.count <= SIZE:
            return self
        sample = Sample.of(self.points, self.normals)
        return replace(self, points=sample.points, normals=sample.normals, count=len(sample.points), stream=None)

    def polynomial(self, degree: int, coefficients: FloatArray, basis: Basis) -> ImplicitPolynomial:
        """Return the polynomial with these coefficients in this basis, in the normalised frame.

        Coefficients of the last form may be missing at the end, and are 0 then.
        """
        frame = Frame(np.zeros(self.points.shape[1]), 1.0)
        a = np.zeros(graded.count(self.points.shape[1], degree))
        a[: len(coefficients)] = coefficients
        return ImplicitPolynomial(degree, a, frame, self.bounds, basis)

    def to_raw(self, polynomial: ImplicitPolynomial) -> ImplicitPolynomial:
        """Return a polynomial of the normalised frame in raw coordinates: the coefficients stay as they are."""
        bounds = self.frame.to_raw(polynomial.bounds)
        return replace(polynomial, frame=self.frame, bounds=bounds)

    def self_check(self) -> float:
        """Return the share of points whose normal agrees with the winding number of them all."""
        return winding.self_check(self.points, self.normals)


def _grown(box: FloatArray) -> FloatArray:
    """Return a box (2, d) with the margin on every side."""
    return np.asarray(box + np.array([[-MARGIN], [MARGIN]]))
