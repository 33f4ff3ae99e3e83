"""Few points, far from all others, that set the unit of length in which the others are small."""

import numpy as np

from ipcore._typing import BoolArray, FloatArray

# A point is far if its distance from the median point is so many times the median of all these distances. In a needle
# the greatest is 2 times the median, in 28 sets of real shapes at most 4.
FAR_RADII = 20.0
FEW_SHARE = 0.1  # more far points are a part of the shape
UNIT_FACTOR = 1.1  # by which few points must enlarge the unit to be worth a warning


def setting_the_unit(points: FloatArray) -> int:
    """Return how many points (N, d), far from all others, make the mean radius much larger than it is without them.

    >>> turn = 2 * np.pi * np.arange(200) / 200
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn)])
    >>> setting_the_unit(circle), setting_the_unit(np.vstack([circle, [[1e6, 0.0]]]))
    (0, 1)
    """
    far = are_few_and_far(points)
    count = int(far.sum())
    if not count:
        return 0
    return count if _mean_radius(points) > UNIT_FACTOR * _mean_radius(points[~far]) else 0


def are_few_and_far(points: FloatArray) -> BoolArray:
    """Return which points (N, d) are far from all others, (N,); none if these are not few."""
    distance = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    far = distance > FAR_RADII * float(np.median(distance))
    return np.asarray(far & (far.sum() <= max(1.0, FEW_SHARE * len(points))))


def _mean_radius(points: FloatArray) -> float:
    return float(np.linalg.norm(points - points.mean(axis=0), axis=1).mean())
