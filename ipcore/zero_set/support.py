"""The support of a zero set: the space near the data, and which points lie in it.

Two radii about the data decide about a part of a zero set. Within the *support radius* the data support it. Between it
and the *gap radius*, which may be larger, it may lie in a gap that random data happen to leave: see `stray`.
"""

import numpy as np
import scipy
from scipy.spatial import cKDTree

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.points.neighbours import nearest
from ipcore.polynomial.frame import Frame

# The support radius in mean radii and in point spacings, whichever is more: chosen over 37 shapes so that neither
# sparse sampling nor noise makes a good fit's own surface stray.
SUPPORT_RADII = {2: 0.10, 3: 0.12}
SUPPORT_SPACINGS = 2.5
# The gap radius is 1.25 times the 99th percentile of the distance to the 6th nearest other point. For N random points
# on a surface with density ρ that is 2.5/√ρ, and a gap of that radius has the probability e⁻²⁰ N; on a square grid it
# is 1.8 spacings.
GAP_NEIGHBOUR = 6
GAP_QUANTILE = 0.99
GAP_FACTOR = 1.25
# Bins along the longest axis of the box of the points. The support radius is at least a tenth of the data's mean
# radius, so several bins: few bins are cut by the surface at that radius.
BINS = 64
# Data by which the spacing of many is estimated: the median is off by 1/25 of the spread, and the 99th percentile that
# the gap radius needs lies between the 98.4th and the 99.6th.
SPACING_SAMPLE = 1024
FEW_POINTS = 1024  # the nearest datum of so few points is found faster than their bins
BIN_SLACK = 0.998  # for rounding, which is below …
LEAST_BIN = 1e-9  # … this share of the coordinates, the least side of a bin


def support_radius_of(dimension: int, scale: float, spacing: float) -> float:
    """Return the distance from the data beyond which a zero set is stray, in the unit of `scale` and `spacing`.

    This is the one definition of stray; `scale` is the mean radius of the data, `spacing` that of the points. Only the
    spacing is estimated in two ways: here by the distance to the nearest other point, in `geometric.violations` by the
    areas for which the points stand.

    >>> support_radius_of(2, 10.0, 1.0), support_radius_of(3, 10.0, 0.1)
    (2.5, 1.2)
    """
    return max(SUPPORT_RADII[dimension] * scale, SUPPORT_SPACINGS * spacing)


def support_radius(data: FloatArray, scale: float) -> float:
    """Return the support radius of data (N, d), raw; `scale` is their mean radius, raw.

    max(0.10 · scale in 2D or 0.12 · scale in 3D, 2.5 · median distance to the nearest other point)

    >>> support_radius(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), scale=10.0)
    2.5
    """
    return support_radius_of(data.shape[1], scale, float(np.median(_spacings(data, 1))))


def gap_radius(data: FloatArray) -> float:
    """Return the gap radius of data (N, d), raw: as large as the gaps that a random sample of a surface has.

    >>> turn = 2 * np.pi * np.arange(100) / 100        # the 6th nearest is 3 steps along
    >>> round(gap_radius(100 / (2 * np.pi) * np.column_stack([np.cos(turn), np.sin(turn)])), 2)
    3.74
    """
    return GAP_FACTOR * float(np.quantile(_spacings(data, GAP_NEIGHBOUR), GAP_QUANTILE))


def is_beyond_support(x: FloatArray, data: FloatArray, threads: int | None = None) -> BoolArray:
    """Return which points x (n, d) are beyond the support radius of the data (N, d), (n,); all raw.

    Most of many points are judged by the cubic bin in which they lie. All points in a bin that holds data are within
    the radius, if the bin's diagonal is shorter. All points in a bin are beyond it if no bin within the radius holds
    data. The nearest datum is searched for the points in the other bins only.

    >>> data = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    >>> is_beyond_support(np.array([[0.1, 0.0], [1.5, 0.0], [9.0, 0.0]]), data).tolist()
    [False, False, True]
    """
    radius = support_radius(data, Frame.of(data).scale)
    if len(x) <= FEW_POINTS:
        return np.isinf(nearest(cKDTree(data), x, within=radius)[0])
    both = [np.concatenate(columns) for columns in zip(x.T, data.T, strict=True)]  # numpy is slow along rows of three
    lower, upper = np.array([c.min() for c in both]), np.array([c.max() for c in both])
    side = max(float((upper - lower).max()) / BINS, LEAST_BIN * float(np.abs([lower, upper]).max()))
    counts = tuple(((upper - lower) // side).astype(np.intp) + 1)
    holds = np.zeros(counts, dtype=np.bool_)
    holds.ravel()[_bins(data, lower, side, counts)] = True
    around = scipy.ndimage.maximum_filter(holds, 2 * int(np.ceil(radius / side)) + 1)
    bins = _bins(x, lower, side, counts)
    near = holds.ravel()[bins] & (side * np.sqrt(x.shape[1]) < BIN_SLACK * radius)
    doubtful = np.flatnonzero(around.ravel()[bins] & ~near)
    far = ~near
    far[doubtful] = np.isinf(nearest(cKDTree(data), x[doubtful], within=radius, threads=threads)[0])
    return np.asarray(far)


def _bins(x: FloatArray, lower: FloatArray, side: float, counts: tuple[int, ...]) -> IntArray:
    """Return the numbers (n,) of the bins, from `lower` (d,) on, in which points x (n, d) lie."""
    at = ((x - lower) / side).astype(np.intp)
    return np.asarray(np.ravel_multi_index(tuple(at.T), counts, mode="clip"))


def _spacings(data: FloatArray, neighbour: int) -> FloatArray:
    """Return the distances (n,) from some of the data (N, d) to their nearest other, the 2nd nearest, and so on.

    If there are not so many others, it is the distance to the farthest. Repeated points count once, for between them
    there is no distance.
    """
    some = data[:: 1 + len(data) // SPACING_SAMPLE]
    k = min(neighbour, len(data) - 1)
    spacings = nearest(cKDTree(data), some, k + 1)[0]
    if spacings[:, 1].all():
        return spacings[:, k]
    distinct = np.unique(data, axis=0)
    return _spacings(distinct, neighbour) if len(distinct) > 1 else spacings[:, k]
