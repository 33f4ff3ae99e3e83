"""The validation of the caller's points and normals, before any computation with them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ipcore._typing import FloatArray
from ipcore.errors import InvalidNormalsError, InvalidPointsError, IPCoreError
from ipcore.points import digest
from ipcore.points.far_points import setting_the_unit
from ipcore.polynomial.frame import Frame

# A principal extent below this share of the longest one counts as 0. Points stored in single precision have rounding
# errors of 6e-8, so a shape thinner than that cannot be distinguished from a line or a plane.
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
    frame
        The normalised frame of the points.
    sha256
        The digest of points and normals, as `ipcore.points.digest` defines it.
    incomplete
        How many more points the caller had, which were left out because a value of theirs was missing.

    """

    points: FloatArray
    normals: FloatArray | None
    planar: bool
    frame: Frame
    sha256: str
    incomplete: int = 0


def check(points: ArrayLike | PointSet, normals: ArrayLike | None = None) -> PointSet:
    """Return points (N, d) and normals (N, d), of any length but 0, as a point set; raise if they cannot be fitted.

    The error says what is wrong, and its `at` where. A `PointSet`, which was checked before, is returned as it is.

    Raises
    ------
    InvalidPointsError
        Wrong shape, NaN or infinite, fewer than d + 1 points, all equal, or all on one line.
    InvalidNormalsError
        Another shape than the points', NaN or infinite, or of zero length; or given beside a `PointSet`.

    Examples
    --------
    >>> check([[0.0, 0.0], [1.0, float("nan")], [0.0, 1.0]])
    Traceback (most recent call last):
    ipcore.errors.InvalidPointsError: points must be finite: row 1, column 1 is nan (1 value in all)

    """
    if isinstance(points, PointSet):
        if normals is not None:
            raise InvalidNormalsError("a PointSet has its own normals: no others can be given", ("normals",))
        return points
    x = matrix("points", points, InvalidPointsError)
    check_shape(x.shape)
    n = None if normals is None else unit(normals, x)
    centred = x - x.mean(axis=0)
    size = extent(centred, x)
    R = np.asarray(np.linalg.qr(centred / size, mode="r"))
    try:
        planar = rank(R, size, float(np.abs(x).max())) < x.shape[1]
    except InvalidPointsError as error:
        far = setting_the_unit(x)
        if not far:
            raise
        raise InvalidPointsError(
            f"{error.message}, to rounding, as {far} of them {'is' if far == 1 else 'are'} so far from all others that "
            "these look like one: remove the far ones",
            ("points",),
        ) from error
    return PointSet(x, n, planar, Frame.of(x), digest.sha256(x, n))


def check_shape(shape: tuple[int, ...]) -> None:
    """Raise if points of this shape (N, d) have neither 2 nor 3 columns, or fewer than d + 1 rows."""
    d = shape[1]
    if d not in (2, 3):
        raise InvalidPointsError(f"points must have 2 or 3 columns, not {d}", ("points",))
    if shape[0] < d + 1:
        raise InvalidPointsError(
            f"{shape[0]} points are too few: a fit of degree 1 in {d}D needs at least {d + 1}", ("points",)
        )


def matrix(name: str, values: ArrayLike, error: type[IPCoreError], start: int = 0) -> FloatArray:
    """Return `values` as finite doubles (n, d), or raise an `error` about `name`.

    `start` is the number of the first row, as the error is to give it.
    """
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
            f"{name} must be finite: row {start + row}, column {column} is {x[row, column]} ({many} in all)",
            (name, start + row, column),
        )
    return x


def unit(normals: ArrayLike, x: FloatArray, start: int = 0) -> FloatArray:
    """Return the normals of points x (n, d) with length 1, (n, d), or raise.

    `start` is the number of the first row, as the error is to give it.
    """
    n = matrix("normals", normals, InvalidNormalsError, start)
    if n.shape != x.shape:
        raise InvalidNormalsError(f"normals have shape {n.shape}, the points {x.shape}: they must match", ("normals",))
    longest = np.abs(n).max(axis=1, keepdims=True)  # divided out first, so that no square over- or underflows
    zero = np.flatnonzero(longest == 0.0)
    if len(zero):
        row = start + int(zero[0])
        raise InvalidNormalsError(
            f"normals must not have length 0: row {row} has ({len(zero)} in all)", ("normals", row)
        )
    n = n / longest
    return np.asarray(n / np.linalg.norm(n, axis=1, keepdims=True))


def extent(centred: FloatArray, x: FloatArray) -> float:
    """Return the largest absolute coordinate of `centred`, points minus their centroid; raise if all points are equal.

    Also raises if they are too large to compute with. `x` are the points themselves; both are (N, d), and the corners
    of the box of all points, (2, d), give the same.
    """
    largest, size = float(np.abs(x).max()), float(np.abs(centred).max())
    if not np.isfinite(size) or size > 1e150:
        raise InvalidPointsError(f"points are too large to compute with: {largest:.3g}", ("points",))
    if size <= 4.0 * np.finfo(float).eps * largest or size < 1e-150:
        raise InvalidPointsError("all points are equal", ("points",))
    return size


def rank(R: FloatArray, extent: float, largest: float) -> int:
    """Return the dimension of the points' affine hull, up to rounding; raise if it is 0 or 1.

    `R` (d, d) is the triangular factor of the centred points divided by their `extent`: its singular values are the
    principal extents, computed without squares. `largest` is the largest absolute raw coordinate.
    """
    spread = np.linalg.svd(R, compute_uv=False)
    tolerance = max(FLATNESS, 16.0 * np.finfo(float).eps * largest / extent)
    dimension = int(np.count_nonzero(spread > tolerance * spread[0]))
    if dimension < 2:
        raise InvalidPointsError("all points lie on one line", ("points",))
    return dimension
