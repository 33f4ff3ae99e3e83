"""Check the caller's points and normals before any work is done on them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ipcore._typing import FloatArray
from ipcore.errors import InvalidNormalsError, InvalidPointsError, IPCoreError

# Below this share of the longest principal extent, an extent counts as none. Points stored in single precision carry
# 6e-8 of rounding; nothing thinner than that can be told from a line or a plane.
FLATNESS = 1e-7


@dataclass(frozen=True, eq=False)
class PointSet:
    """Points that can be fitted, and their normals if the caller gave any.

    Attributes
    ----------
    points
        (N, d), finite, double precision, raw coordinates.
    normals
        (N, d), unit length, or None.
    planar
        Whether 3D points all lie on one plane, which a polynomial of degree 1 represents.

    """

    points: FloatArray
    normals: FloatArray | None
    planar: bool


def check(points: ArrayLike, normals: ArrayLike | None = None) -> PointSet:
    """Return the point set, or say what is wrong with it and where.

    Raises
    ------
    InvalidPointsError
        Wrong shape, NaN or infinite, fewer than d + 1 points, all equal, or all on one line.
    InvalidNormalsError
        Another shape than the points', NaN or infinite, or of zero length.

    Examples
    --------
    >>> check([[0.0, 0.0], [1.0, float("nan")], [0.0, 1.0]])
    Traceback (most recent call last):
    ipcore.errors.InvalidPointsError: points must be finite: row 1, column 1 is nan (1 value in all)

    """
    x = _matrix("points", points, InvalidPointsError)
    d = x.shape[1]
    if d not in (2, 3):
        raise InvalidPointsError(f"points must have 2 or 3 columns, not {d}", ("points",))
    if len(x) < d + 1:
        raise InvalidPointsError(
            f"{len(x)} points are too few: a fit of degree 1 in {d}D needs at least {d + 1}", ("points",)
        )
    return PointSet(x, None if normals is None else _unit(normals, x), _rank(x) < d)


def _matrix(name: str, values: ArrayLike, error: type[IPCoreError]) -> FloatArray:
    try:
        x = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as cause:
        raise error(f"{name} must be an array of numbers with one row per point: {cause}", (name,)) from cause
    if x.ndim != 2:
        raise error(f"{name} must have two axes, one row per point, not shape {x.shape}", (name,))
    bad = np.argwhere(~np.isfinite(x))
    if len(bad):
        row, column = (int(i) for i in bad[0])
        many = "1 value" if len(bad) == 1 else f"{len(bad)} values"
        raise error(
            f"{name} must be finite: row {row}, column {column} is {x[row, column]} ({many} in all)",
            (name, row, column),
        )
    return x


def _unit(normals: ArrayLike, x: FloatArray) -> FloatArray:
    """Return normals of length 1."""
    n = _matrix("normals", normals, InvalidNormalsError)
    if n.shape != x.shape:
        raise InvalidNormalsError(f"normals have shape {n.shape}, the points {x.shape}: they must match", ("normals",))
    longest = np.abs(n).max(axis=1, keepdims=True)  # divided out first, so that no square over- or underflows
    zero = np.flatnonzero(longest == 0.0)
    if len(zero):
        raise InvalidNormalsError(
            f"normals must not have length 0: row {zero[0]} has ({len(zero)} in all)", ("normals", int(zero[0]))
        )
    n = n / longest
    return np.asarray(n / np.linalg.norm(n, axis=1, keepdims=True))


def _rank(x: FloatArray) -> int:
    """Return the dimension of the affine hull, to rounding; refuse 0 and 1."""
    largest = np.abs(x).max()
    centred = x - x.mean(axis=0)
    extent = np.abs(centred).max()
    if not np.isfinite(extent) or extent > 1e150:
        raise InvalidPointsError(f"points are too large to compute with: {largest:.3g}", ("points",))
    if extent <= 4.0 * np.finfo(float).eps * largest or extent < 1e-150:
        raise InvalidPointsError("all points are equal", ("points",))
    spread = _spread(centred / extent)
    tolerance = max(FLATNESS, 16.0 * np.finfo(float).eps * largest / extent)
    rank = int(np.count_nonzero(spread > tolerance * spread[0]))
    if rank < 2:
        raise InvalidPointsError("all points lie on one line", ("points",))
    return rank


def _spread(x: FloatArray) -> FloatArray:
    """Return the principal extents, largest first, from the triangular factor: no square is formed."""
    return np.linalg.svd(np.linalg.qr(x, mode="r"), compute_uv=False)
