"""The data as the fit sees it: normalised, oriented, boxed."""

import hashlib
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ipcore import monomials, winding
from ipcore._typing import FloatArray
from ipcore.basis import Basis
from ipcore.frame import Frame
from ipcore.normals import NormalSource, orient
from ipcore.points import PointSet
from ipcore.polynomial import ImplicitPolynomial

# The fit's bounds are the data's box grown by this much on every side, in mean radii: room for the zero set to close
# round the data, and for the outer layers (layer_distance is at most this).
MARGIN = 0.3


@dataclass(frozen=True, eq=False)
class OrientedPoints:
    """Points and unit outward normals in the normalised frame.

    Attributes
    ----------
    points, normals
        (N, d), in the frame.
    frame
        From raw coordinates and back.
    bounds
        (2, d), in the frame: the box in which the fit is made.
    source
        Where the normals came from.
    planar
        Whether all points lie on one plane (3D).

    """

    points: FloatArray
    normals: FloatArray
    frame: Frame
    bounds: FloatArray
    source: NormalSource
    planar: bool

    @classmethod
    def of(cls, given: PointSet, neighbours: int) -> Self:
        """Normalise, and orient if the caller gave no normals."""
        frame = Frame.of(given.points)
        x = frame.to_local(given.points)
        normals, source = (given.normals, NormalSource.GIVEN) if given.normals is not None else orient(x, neighbours)
        bounds = np.stack([x.min(axis=0) - MARGIN, x.max(axis=0) + MARGIN])
        return cls(x, normals, frame, bounds, source, given.planar)

    def polynomial(self, degree: int, coefficients: FloatArray, basis: Basis) -> ImplicitPolynomial:
        """Return the polynomial with these coefficients in this basis, in the normalised frame.

        Coefficients of the last form may be missing at the end, and are 0 then.
        """
        frame = Frame(np.zeros(self.points.shape[1]), 1.0)
        a = np.zeros(monomials.count(self.points.shape[1], degree))
        a[: len(coefficients)] = coefficients
        return ImplicitPolynomial(degree, a, frame, self.bounds, basis)

    def to_raw(self, polynomial: ImplicitPolynomial) -> ImplicitPolynomial:
        """Return a polynomial of the normalised frame in raw coordinates: the coefficients stay as they are."""
        bounds = self.frame.to_raw(polynomial.bounds)
        return replace(polynomial, frame=self.frame, bounds=bounds)

    def self_check(self) -> float:
        """Return the share of points whose normal agrees with the winding number of them all."""
        return winding.self_check(self.points, self.normals)


def sha256(given: PointSet) -> str:
    """Return the SHA-256 of points and normals: shapes, then little-endian doubles in C order."""
    digest = hashlib.sha256()
    for array in (given.points, given.normals):
        if array is not None:
            digest.update(repr(array.shape).encode())
            digest.update(np.ascontiguousarray(array, dtype="<f8").data)
    return digest.hexdigest()
