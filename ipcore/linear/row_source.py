"""The rows of a linear system, known only by sums over them: R and b̃, and the residuals of the normal equations.

The rows are made of the data part by part, or only their moments are there.
"""

from collections.abc import Iterator
from functools import partial, reduce
from operator import add
from typing import Protocol

import numpy as np

from ipcore import _threads
from ipcore._typing import FloatArray
from ipcore.linear import layer_moments
from ipcore.linear.design_matrix import DesignMatrix
from ipcore.linear.layer_moments import LayerMoments
from ipcore.linear.qr.r_factor import RFactor
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints, Part
from ipcore.polynomial import graded
from ipcore.polynomial.univariate import Basis

TSQR_CHUNK_ROWS = 4096  # rows of M that are factored at once: 32 MB at degree 16 in 3D
# The condition κ₁, as LAPACK estimates it (about ten times κ₂), up to which R from MᵀM can be used. Where the solution
# can be corrected by the rows, at the limit the first correction reduces the error by hardly more than a factor of two.
# Where it cannot, the solution must be good as it is: over 26 sets D_dist was off by less than 2e-7 of itself.
MAX_CONDITION_WITH_ROWS, MAX_CONDITION_OF_MOMENTS = 1e9, 1e6


class RowSource(Protocol):
    """The rows of a linear system M a = b.

    Attributes
    ----------
    max_condition
        The condition of R up to which the result of `from_moments` can be used.

    """

    max_condition: float

    def from_moments(self, degree: int) -> RFactor:
        """Return R and b̃ from MᵀM, for the columns up to this degree or as many of them as can be factored."""
        ...

    def from_rows(self, degree: int) -> RFactor | None:
        """Return R and b̃ from the rows themselves, for the columns up to this degree; None if there are no rows."""
        ...

    def normal_residuals(self, degree: int, A: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Return Mᵀ(b − M a) (m, p) and ‖b − M a‖² (p,) for the columns a of A (m, p), summed row by row.

        None if there are no rows.
        """
        ...


class DataRows:
    """The rows that a constraint family makes of the data, one part at a time."""

    max_condition = MAX_CONDITION_WITH_ROWS

    def __init__(self, data: OrientedPoints, options: FitOptions) -> None:
        """Take the data, and the options of the family."""
        self._data, self._options = data, options

    def from_moments(self, degree: int) -> RFactor:
        """Return R and b̃ from MᵀM."""
        of_part = partial(_moments, degree, self._options.layer_offsets)
        return reduce(add, _threads.ordered(of_part, self._data.parts())).r_factor()

    def from_rows(self, degree: int) -> RFactor:
        """Return R and b̃ from the rows themselves."""
        of_part = partial(_r_factor, degree, self._options, self._data.bounds)
        return reduce(RFactor.joined, _threads.ordered(of_part, self._data.parts()))

    def normal_residuals(self, degree: int, A: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return Mᵀ(b − M a) (m, p) and ‖b − M a‖² (p,) for the columns a of A (m, p)."""
        of_part = partial(_normal_residuals, degree, self._options.layer_offsets, A)
        g, rss = zip(*_threads.ordered(of_part, self._data.parts()), strict=True)
        return np.add.reduce(g), np.add.reduce(rss)


class SummedRows(DataRows):
    """The same rows, whose moments up to some degree were summed before."""

    def __init__(self, data: OrientedPoints, options: FitOptions, moments: LayerMoments) -> None:
        """Take the data, the options of the family, and the moments in the data's frame."""
        super().__init__(data, options)
        self._moments = moments

    def from_moments(self, degree: int) -> RFactor:
        """Return R and b̃ from MᵀM: from the moments that are there, if they reach this degree."""
        return self._moments.r_factor() if degree <= self._moments.degree else super().from_moments(degree)


class MomentRows:
    """The moments of rows that are not there any more."""

    max_condition = MAX_CONDITION_OF_MOMENTS

    def __init__(self, moments: LayerMoments) -> None:
        """Take the moments."""
        self._moments = moments

    def from_moments(self, degree: int) -> RFactor:  # noqa: ARG002 - always for all degrees of the moments
        """Return R and b̃ from MᵀM."""
        return self._moments.r_factor()

    def from_rows(self, degree: int) -> None:
        """Return None: there are no rows."""

    def normal_residuals(self, degree: int, A: FloatArray) -> None:
        """Return None: there are no rows."""


def _moments(degree: int, offsets: tuple[float, ...], part: Part) -> LayerMoments:
    return LayerMoments.of(part.points, part.normals, degree, offsets)


def _normal_residuals(
    degree: int, offsets: tuple[float, ...], A: FloatArray, part: Part
) -> tuple[FloatArray, FloatArray]:
    return layer_moments.normal_residuals(part.points, part.normals, degree, offsets, A)


def _r_factor(degree: int, options: FitOptions, bounds: FloatArray, part: Part) -> RFactor:
    """Return R and b̃ of the rows of one part, factored chunk by chunk."""
    d = part.points.shape[1]
    m = graded.count(d, degree)

    def chunks() -> Iterator[tuple[FloatArray, FloatArray]]:
        size = max(1, TSQR_CHUNK_ROWS // options.family.rows_per_point(d))
        for start in range(0, len(part.points), size):
            chunk = slice(start, start + size)
            rows = options.family.rows(part.points[chunk], part.normals[chunk], options.row_parameters)
            yield DesignMatrix(rows, Basis.MONOMIAL, bounds, degree).columns(0, m), rows.b(degree)

    return RFactor.of_rows(m, chunks())
