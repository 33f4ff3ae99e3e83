"""The support of a zero set: the space near the data, and which points lie in it.

Two radii about the data, both raw, decide about a part of a zero set. Beyond the *support radius* the part is stray:
no data are near enough to support it. Within the *gap radius*, which may be larger, a restricted zero set keeps the
part all the same, so that it has no holes where random data happen to leave gaps.

Most points are compared with the radii by the cubic bin in which they lie, without a search for their nearest datum.
"""

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from ipcore._threads import by_rows
from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.points.neighbours import SERIAL_QUERIES, nearest
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
SPACING_SAMPLE = 1024  # data by which the spacing of many is estimated: its median is off by 1/25 of the spread
BIN_HALF = 0.501  # half a bin's side, in sides: a little more for rounding, which is below …
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
    return _support_radius(_spacings(cKDTree(data), None), data.shape[1], scale)


def gap_radius(data: FloatArray) -> float:
    """Return the gap radius of data (N, d), raw: as large as the gaps that a random sample of a surface has.

    >>> turn = 2 * np.pi * np.arange(100) / 100        # the 6th nearest is 3 steps along
    >>> round(gap_radius(100 / (2 * np.pi) * np.column_stack([np.cos(turn), np.sin(turn)])), 2)
    3.74
    """
    return _gap_radius(_spacings(cKDTree(data), None))


def radii_exceeded(x: FloatArray, data: FloatArray, threads: int | None = None) -> IntArray:
    """Return for points x (n, d) how many of the two radii of the data (N, d) they are beyond, (n,); all raw.

    0: within the support radius. 1: beyond it, but within the gap radius. 2: beyond both.
    """
    tree = cKDTree(data)
    spacings = _spacings(tree, threads)
    support = _support_radius(spacings, data.shape[1], Frame.of(data).scale)
    return distances_exceeded(tree, x, (support, max(support, _gap_radius(spacings))), threads)


def is_stray(x: FloatArray, data: FloatArray) -> BoolArray:
    """Return which points x (n, d) are beyond the support radius of the data (N, d), (n,); all raw.

    The spacing of many data is estimated by some of them. All points in a bin that holds data are within the radius, if
    the bin's diagonal is shorter. All points in a bin are beyond it if no bin within the radius holds data. The nearest
    datum is searched for the points in the other bins only.

    >>> data = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    >>> is_stray(np.array([[0.1, 0.0], [1.5, 0.0], [9.0, 0.0]]), data).tolist()
    [False, False, True]
    """
    if not len(x):
        return np.zeros(0, dtype=np.bool_)
    tree, d = cKDTree(data), data.shape[1]
    spacings = nearest(tree, data[:: 1 + len(data) // SPACING_SAMPLE], 2)[0][:, 1:]
    radius = _support_radius(spacings, d, Frame.of(data).scale)
    both = [np.concatenate(columns) for columns in zip(x.T, data.T, strict=True)]  # numpy is slow along rows of three
    lower, upper = np.array([c.min() for c in both]), np.array([c.max() for c in both])
    side = max(float((upper - lower).max()) / BINS, LEAST_BIN * float(np.abs([lower, upper]).max()))
    counts = tuple(((upper - lower) // side).astype(np.intp) + 1)
    holds = np.zeros(counts, dtype=np.bool_)
    holds.ravel()[_bins(data, lower, side, counts)] = True
    around = ndimage.maximum_filter(holds, 2 * int(np.ceil(radius / side)) + 1)
    bins = _bins(x, lower, side, counts)
    near = holds.ravel()[bins] & (2.0 * BIN_HALF * side * np.sqrt(d) < radius)
    doubtful = np.flatnonzero(around.ravel()[bins] & ~near)
    far = ~near
    far[doubtful] = np.isinf(nearest(tree, x[doubtful], within=radius)[0])
    return np.asarray(far)


def distances_exceeded(tree: cKDTree, x: FloatArray, radii: tuple[float, ...], threads: int | None = None) -> IntArray:
    """Return for points x (n, d) how many of the ascending radii are less than the distance to the tree's points, (n,).

    If x are many, the nearest point is searched for the middles of cubic bins, and for a point of x itself only if the
    distances in its bin may be on both sides of a radius.

    >>> distances_exceeded(cKDTree([[0.0, 0.0]]), np.array([[0.5, 0.0], [1.5, 0.0], [2.5, 0.0]]), (1.0, 2.0)).tolist()
    [0, 1, 2]
    """
    if len(x) <= SERIAL_QUERIES:
        return np.searchsorted(radii, nearest(tree, x, within=2.0 * radii[-1], threads=threads)[0])
    lower, upper = x.min(axis=0), x.max(axis=0)
    side = max(float((upper - lower).max()) / BINS, LEAST_BIN * float(np.abs(x).max())) or 1.0
    counts = tuple(((upper - lower) // side).astype(np.intp) + 1)
    bins = by_rows(lambda part: _bins(x[part], lower, side, counts), len(x), threads)
    used = np.flatnonzero(np.bincount(bins))
    middles = lower + side * (np.stack(np.unravel_index(used, counts), axis=1) + 0.5)
    extent = BIN_HALF * side * np.sqrt(len(lower))
    distance = nearest(tree, middles, within=radii[-1] + 2.0 * extent, threads=threads)[0]
    least, most = (np.searchsorted(radii, distance + shift) for shift in (-extent, extent))
    table = np.full(int(np.prod(counts)), -1)
    table[used] = np.where(least == most, least, -1)
    found = table[bins]
    cut = np.flatnonzero(found < 0)
    found[cut] = np.searchsorted(radii, nearest(tree, x[cut], within=2.0 * radii[-1], threads=threads)[0])
    return found


def _bins(x: FloatArray, lower: FloatArray, side: float, counts: tuple[int, ...]) -> IntArray:
    """Return the numbers (n,) of the bins, from `lower` (d,) on, in which points x (n, d) lie."""
    at = ((x - lower) / side).astype(np.intp)
    return np.asarray(np.ravel_multi_index(tuple(at.T), counts, mode="clip"))


def _spacings(tree: cKDTree, threads: int | None) -> FloatArray:
    """Return the distances (N, k) from each point of a tree to its nearest others, up to the GAP_NEIGHBOUR-th."""
    k = min(GAP_NEIGHBOUR, tree.n - 1)
    return nearest(tree, tree.data, k + 1, threads=threads)[0][:, 1:]


def _support_radius(spacings: FloatArray, d: int, scale: float) -> float:
    """Return the support radius; the spacing is the median distance to the nearest other point, `spacings[:, 0]`."""
    return support_radius_of(d, scale, float(np.median(spacings[:, 0])))


def _gap_radius(spacings: FloatArray) -> float:
    """Return the gap radius from the distances (N, ≤ GAP_NEIGHBOUR) to the nearest other points."""
    return GAP_FACTOR * float(np.quantile(spacings[:, -1], GAP_QUANTILE))
