"""Outliers: points so far from all others that they say nothing about the shape, and how they would disturb a fit.

A single point at a great distance sets the unit in which everything is measured. So a robust fit leaves it out before
the frame is made, the normals are estimated and oriented, and the sides are found.
"""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ipcore._typing import BoolArray, FloatArray
from ipcore.points import winding
from ipcore.points.far_points import are_few_and_far
from ipcore.points.neighbours import nearest
from ipcore.points.validation import PointSet, check

ISOLATED_SPACINGS = 3.0  # median spacings: a point with a greater spacing of its own may be an outlier
# A point whose spacing is greater than this is one. In random samples of curves and surfaces the greatest of 3,000
# points' spacings is 6 medians.
FAR_SPACINGS = 10.0
# So is a group of points that are nearer to each other than FAR_SPACINGS, and farther from all others, if it is no more
# than this share of all points, or no more than so many.
GROUP_SHARE, GROUP_POINTS = 0.005, 8


def crowded(points: FloatArray) -> BoolArray:
    """Return which points (N, d) have a spacing below `ISOLATED_SPACINGS` times the median, (N,).

    The others may be outliers, or points that a random sample happens to have in a sparse place.

    >>> line = np.column_stack([np.arange(50.0), np.zeros(50)])
    >>> bool(crowded(np.vstack([line, [[20.0, 15.0]]]))[-1]), int(crowded(line).sum())
    (False, 50)
    """
    spacing = _spacing(points)
    return np.asarray(spacing < ISOLATED_SPACINGS * np.median(spacing))


def is_far(points: FloatArray) -> BoolArray:
    """Return which points (N, d) are surely outliers, (N,): far from all others, alone or in a small group.

    Far are places beyond `FAR_SPACINGS` of the shape, and few points that `far_points` finds, whatever their number.

    >>> line = np.column_stack([np.arange(50.0), np.zeros(50)])
    >>> is_far(np.vstack([line, [[20.0, 90.0], [20.0, 90.1]]])).nonzero()[0].tolist()
    [50, 51]
    """
    spacing = _spacing(points)
    median = float(np.median(spacing))
    far = spacing > FAR_SPACINGS * median
    if median == 0.0:
        return are_few_and_far(points)
    rest = np.flatnonzero(~far)
    far[rest[_in_small_groups(points[rest], FAR_SPACINGS * median)]] = True
    return np.asarray(far | are_few_and_far(points))


def without_outliers(given: PointSet) -> tuple[PointSet, int]:
    """Return a point set without what `is_far`, checked anew and in a frame of its own, and the number left out.

    If too few points would be left to be fitted, the point set is returned as it is.
    """
    inlying = ~is_far(given.points)
    count = int(len(inlying) - inlying.sum())
    if not count or inlying.sum() <= given.points.shape[1]:
        return given, 0
    left = check(given.points[inlying], None if given.normals is None else given.normals[inlying])
    return replace(left, sha256=given.sha256, incomplete=given.incomplete), count


def _spacing(points: FloatArray) -> FloatArray:
    return np.asarray(winding.areas(points) ** (1.0 / (points.shape[1] - 1)))


def _in_small_groups(points: FloatArray, reach: float) -> BoolArray:
    """Return which points (N, d) are in a small group, farther than `reach` from all that are not in it, (N,)."""
    N = len(points)
    distance, index = nearest(cKDTree(points), points, min(GROUP_POINTS, N - 1) + 1)
    i, k = np.nonzero(distance[:, 1:] <= reach)
    graph = coo_array((np.ones(len(i)), (i, index[:, 1:][i, k])), shape=(N, N))
    labels = connected_components(graph, directed=False)[1]
    return np.asarray(np.bincount(labels)[labels] <= min(max(GROUP_POINTS, GROUP_SHARE * N), N / 4))
