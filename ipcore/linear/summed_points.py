"""A point set as sums that add: moments of its layers, its box, and a sample of its points."""

from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from pathlib import Path
from typing import IO, Self

import numpy as np
from numpy.typing import ArrayLike

from ipcore import _threads
from ipcore._typing import FloatArray
from ipcore.constraints.registry import LAYERED_NAMES
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.linear.layer_moments import LayerMoments
from ipcore.options.degrees import HIGHEST_DEGREE
from ipcore.options.fit_options import FitOptions
from ipcore.options.ranges import check_integer
from ipcore.points import validation
from ipcore.points.sample import Sample
from ipcore.polynomial.frame import Frame


@dataclass(frozen=True, eq=False)
class SummedPoints:
    """The sums over a point set, with a sample of it.

    Attributes
    ----------
    frame
        The normalised frame. It stays that of the first points: moments in different frames do not add.
    layers
        The moments of the layers, in the frame.
    box
        (2, d), raw: lower and upper corner of all points.
    sample
        50,000 points at most, raw, with unit normals.

    """

    frame: Frame
    layers: LayerMoments
    box: FloatArray
    sample: Sample

    @classmethod
    def of(  # noqa: PLR0913 - the points, the sums to make of them, and the threads
        cls,
        points: ArrayLike,
        normals: ArrayLike,
        *,
        degree: int,
        options: FitOptions | None = None,
        frame: Frame | None = None,
        threads: int | None = None,
    ) -> Self:
        """Return the sums over points.

        Parameters
        ----------
        points, normals
            (N, d) each, raw; normals outward, of any length.
        degree
            The highest degree n that can be fitted. Size and time grow with the number of moments, C(2n + d, d).
        options
            Only `constraints`, 3l or 5l, and `layer_distance` are used.
        frame
            The normalised frame; by default that of these points. Sets that will be merged need the same one. If a
            frame is given, the points may be part of a set, and may lie on one line.
        threads
            As for `ipcore.fit`.

        Raises
        ------
        InvalidPointsError, InvalidNormalsError
            If something is wrong with the points or the normals.
        InvalidOptionsError
            If moments do not determine a fit with these constraints, or the degree is out of range.

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
        check_integer("degree", degree, 1, HIGHEST_DEGREE[x.shape[1]])
        empty = LayerMoments.empty(x.shape[1], degree, offsets)
        start = cls(frame or Frame.of(x), empty, np.stack([x.min(axis=0), x.max(axis=0)]), Sample.empty(x.shape[1]))
        return start.extended(x, normals, threads=threads)

    @property
    def count(self) -> int:
        """Return N, the number of points."""
        return self.layers.count

    @property
    def degree(self) -> int:
        """Return the highest degree that can be fitted."""
        return self.layers.degree

    def extended(self, points: ArrayLike, normals: ArrayLike, *, threads: int | None = None) -> Self:
        """Return the sums over these points and more, (n, d) each, raw. The cost is that of the new ones alone.

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
            chunks = ((x[s], n[s]) for s in _threads.slices(len(x)))
            layers = reduce(add, _threads.ordered(self._layer_moments, chunks))
        return self + type(self)(self.frame, layers, box, Sample.of(x, n))

    def without_sample(self) -> Self:
        """Return the same sums without the sample of points, which takes most of the memory.

        They can be added, and fitted together with the points that they are of.
        """
        return replace(self, sample=Sample.empty(self.layers.dimension))

    def __add__(self, other: "SummedPoints") -> Self:
        """Return the sums over both sets together.

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

    def save(self, file: str | Path | IO[bytes]) -> None:
        """Write the sums and the sample to an npz file."""
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
        """Read a file that `save` wrote.

        Raises
        ------
        InvalidPointsError
            If it is another file.

        """
        try:
            with np.load(file, allow_pickle=False) as arrays:
                frame = Frame(arrays["centre"], float(arrays["scale"]))
                offsets = tuple(arrays["offsets"].tolist())
                layers = LayerMoments(int(arrays["degree"]), offsets, int(arrays["count"]), arrays["sums"])
                return cls(frame, layers, arrays["box"], Sample.of(arrays["points"], arrays["normals"]))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InvalidPointsError(f"not a file of moments: {error}") from error

    def _layer_moments(self, chunk: tuple[FloatArray, FloatArray]) -> LayerMoments:
        """Return the moments of the layers of points (n, d), raw, with unit normals (n, d)."""
        x, n = chunk
        return LayerMoments.of(self.frame.to_local(x), n, self.degree, self.layers.offsets)
