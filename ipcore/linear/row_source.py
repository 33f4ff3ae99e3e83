"""Where a compressed fit gets its triangles from: the data, part by part."""

from collections.abc import Iterator
from functools import partial, reduce
from operator import add
from typing import Protocol

import numpy as np

from ipcore import _threads
from ipcore._typing import FloatArray
from ipcore.linear import layer_moments
from ipcore.linear.design_matrix import System
from ipcore.linear.layer_moments import LayerMoments
from ipcore.linear.qr.r_factor import RFactor
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints, Part
from ipcore.polynomial import graded
from ipcore.polynomial.univariate import Basis

ROWS = 4096  # of M at once: 32 MB at degree 16 in 3D
# κ₁, as LAPACK estimates it (ten times κ₂ or so), up to which a triangle by way of MᵀM is of use. With rows to correct
# the answer by, a correction gains hardly more than a factor of two at the first. Without them the answer has to be
# good as it is: over 26 sets D_dist was off by less than 2e-7 of itself below the second.
CORRECTED, ALONE = 1e9, 1e6


class RowSource(Protocol):
    """The rows of a linear system, known by what can be summed over them.

    Attributes
    ----------
    worst
        The condition up to which `squared` is of use.

    """

    worst: float

    def squared(self, degree: int) -> RFactor:
        """Return the triangle by way of MᵀM, for the columns up to this degree or as many as can be factored."""
        ...

    def exact(self, degree: int) -> RFactor | None:
        """Return the triangle of the rows themselves; None if they are not there any more."""
        ...

    def gradients(self, degree: int, A: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Return Mᵀ(b − M a) (m, p) and ‖b − M a‖² (p,) for the columns a of A (m, p), from the rows themselves.

        None if they are not there any more.
        """
        ...


class DataRows:
    """The rows that a constraint family makes of the data, a part at a time."""

    worst = CORRECTED

    def __init__(self, data: OrientedPoints, options: FitOptions) -> None:
        """Take the data; of the options, what concerns the rows."""
        self._data, self._options = data, options

    def squared(self, degree: int) -> RFactor:
        """Return the triangle by way of MᵀM."""
        of = partial(_moments, degree, self._options.layer_offsets)
        return reduce(add, _threads.ordered(of, self._data.parts())).triangle()

    def exact(self, degree: int) -> RFactor:
        """Return the triangle of the rows themselves."""
        of = partial(_triangle, degree, self._options, self._data.bounds)
        return reduce(RFactor.joined, _threads.ordered(of, self._data.parts()))

    def gradients(self, degree: int, A: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return Mᵀ(b − M a) (m, p) and ‖b − M a‖² (p,) for the columns a of A (m, p)."""
        of = partial(_gradients, degree, self._options.layer_offsets, A)
        g, rss = zip(*_threads.ordered(of, self._data.parts()), strict=True)
        return np.add.reduce(g), np.add.reduce(rss)


class SummedRows(DataRows):
    """The same, with their moments already summed up to some degree."""

    def __init__(self, data: OrientedPoints, options: FitOptions, moments: LayerMoments) -> None:
        """Take the data, what concerns the rows, and the moments, in the data's frame."""
        super().__init__(data, options)
        self._moments = moments

    def squared(self, degree: int) -> RFactor:
        """Return the triangle by way of MᵀM."""
        return self._moments.triangle() if degree <= self._moments.degree else super().squared(degree)


class MomentRows:
    """Rows of which nothing is left but their moments."""

    worst = ALONE

    def __init__(self, moments: LayerMoments) -> None:
        """Take the moments."""
        self._moments = moments

    def squared(self, degree: int) -> RFactor:  # noqa: ARG002 - all there is
        """Return the triangle by way of MᵀM."""
        return self._moments.triangle()

    def exact(self, degree: int) -> None:
        """Return None: the rows are not there any more."""

    def gradients(self, degree: int, A: FloatArray) -> None:
        """Return None: the rows are not there any more."""


def _moments(degree: int, offsets: tuple[float, ...], part: Part) -> LayerMoments:
    return LayerMoments.of(part.points, part.normals, degree, offsets)


def _gradients(degree: int, offsets: tuple[float, ...], A: FloatArray, part: Part) -> tuple[FloatArray, FloatArray]:
    return layer_moments.gradients(part.points, part.normals, degree, offsets, A)


def _triangle(degree: int, options: FitOptions, bounds: FloatArray, part: Part) -> RFactor:
    m = graded.count(part.points.shape[1], degree)

    def chunks() -> Iterator[tuple[FloatArray, FloatArray]]:
        size = max(1, ROWS // options.family.rows_per_point(part.points.shape[1]))
        for start in range(0, len(part.points), size):
            some = slice(start, start + size)
            rows = options.family.rows(part.points[some], part.normals[some], options.row_parameters)
            yield System(rows, Basis.MONOMIAL, bounds, degree).columns(0, m), rows.b(degree)

    return RFactor.of_rows(m, chunks())
