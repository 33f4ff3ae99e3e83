"""Coverage: the share of the data that have a zero of f near them.

The first-order distance |f|/‖∇f‖ is small also where f is small but has no zero. What proves a zero within h of a point
x is a change of the sign of f among places that are at most h away from x, for f is continuous.
"""

from collections.abc import Iterator

import numpy as np

from ipcore import _threads
from ipcore._typing import FloatArray
from ipcore.points.oriented import OrientedPoints, Part
from ipcore.polynomial.implicit import ImplicitPolynomial

COVERED_T1 = 3.0  # a point is covered if there is a zero within so many t1
DEFAULT_T1 = 0.01  # mean radii, in place of a t1 of 0
LEAST_COVERAGE = 0.9  # of a fit that meets the stopping rule
# To first order f has the other sign at twice the distance of the zero set. Where x is on the zero set, to rounding,
# the step is this, in mean radii.
LEAST_STEP = 1e-7
STEP_SHARES = (1.0, 0.25, 0.06)  # of h: the steps that are tried where the first-order one shows no change of sign


def coverage(
    polynomial: ImplicitPolynomial, data: OrientedPoints, t1: float, weights: FloatArray | None = None
) -> float:
    """Return the share of the data that have a zero of f within 3 t1, both in the normalised frame.

    Parameters
    ----------
    polynomial, data
        In the normalised frame. Of more than 50,000 points a sample is taken.
    t1
        The threshold of D_dist, in mean radii; for 0, its default of 0.01 is taken.
    weights
        (N,), of all points in memory; those of weight 0 do not count.

    """
    h = COVERED_T1 * (t1 or DEFAULT_T1)
    if weights is not None:
        some = weights > 0.0
        covered = [_covered(polynomial, data.points[some], data.normals[some], h)]
    else:
        parts = data.thinned.held_parts()
        covered = list(_threads.ordered(lambda part: _of_part(polynomial, part, h), parts))
    return float(np.concatenate(covered).mean())


def _of_part(polynomial: ImplicitPolynomial, part: Part, h: float) -> FloatArray:
    return _covered(polynomial, part.points, part.normals, h)


def _covered(polynomial: ImplicitPolynomial, x: FloatArray, normals: FloatArray, h: float) -> FloatArray:
    """Return 1 for each of the points x (n, d) that has a zero within h, else 0, (n,)."""
    f, gradient = polynomial.value_and_gradient(x)
    slope = np.linalg.norm(gradient, axis=1)
    flat = slope <= np.finfo(float).tiny
    direction = np.where(flat[:, None], normals, gradient / np.where(flat, 1.0, slope)[:, None])
    step = np.clip(2.0 * np.abs(f) / np.where(flat, 1.0, slope), LEAST_STEP, h)[:, None] * direction
    negative, positive = f < 0.0, f > 0.0
    for places in (x - step, x + step):
        values = polynomial(places)
        negative, positive = negative | (values < 0.0), positive | (values > 0.0)
    covered = negative & positive
    for offsets in _offsets(normals, h):
        rest = np.flatnonzero(~covered)
        if not len(rest):
            break
        values = polynomial(x[rest] + offsets[rest])
        negative[rest] |= values < 0.0
        positive[rest] |= values > 0.0
        covered = negative & positive
    return np.asarray(covered, dtype=np.float64)


def _offsets(normals: FloatArray, h: float) -> Iterator[FloatArray]:
    """Yield offsets (n, d) of length h and less: along the normals (n, d), and at right angles to them."""
    axis = np.zeros_like(normals)
    axis[np.arange(len(normals)), np.abs(normals).argmin(axis=1)] = 1.0
    tangent = axis - (axis * normals).sum(axis=1, keepdims=True) * normals
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    directions = [normals, tangent]
    if normals.shape[1] == 3:
        directions.append(np.cross(normals, tangent))
    for scale in STEP_SHARES:
        for direction in directions:
            yield scale * h * direction
            yield -scale * h * direction
