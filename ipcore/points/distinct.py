"""Distinct points: copies of a point say nothing that the first did not, and disturb what is measured between points.

A copy is no neighbour: spacings of 0, areas of 0 and normals without direction would follow. Nor does it determine a
coefficient.
"""

from dataclasses import replace

import numpy as np

from ipcore._typing import FloatArray, IntArray
from ipcore.errors import InvalidPointsError
from ipcore.points.validation import PointSet
from ipcore.polynomial.frame import Frame

# Weights of coordinates. Points that differ have different weighted sums, but for rare coincidences.
MIXING_WEIGHTS = (1.0, np.sqrt(2.0), np.sqrt(3.0))
# The mean of the unit normals of copies is at least so long if they agree. If it is shorter, the surface passes through
# the place more than once, and the copies are kept.
AGREEING = 0.5


def may_repeat(points: FloatArray) -> bool:
    """Return whether points (N, d) may have copies among them; if not, they surely have none.

    >>> may_repeat(np.array([[0.0, 1.0], [1.0, 0.0]])), may_repeat(np.array([[0.0, 1.0], [0.0, 1.0]]))
    (False, True)
    """
    mixed = np.sort(sum(weight * x for weight, x in zip(MIXING_WEIGHTS, points.T, strict=False)))
    return bool(len(mixed) < 2 or (mixed[1:] == mixed[:-1]).any())


def without_copies(given: PointSet) -> tuple[PointSet, int]:
    """Return a point set with one of each of its points, and the number of points that were merged into others.

    The points keep the order in which each first appears, the first of an outline, too. A point's normal is the mean of
    those of its copies; if these contradict each other, all its copies are kept. The frame is that of the points which
    are left.

    Raises
    ------
    InvalidPointsError
        If fewer than d + 1 points are distinct.

    """
    points, normals = given.points, given.normals
    if not may_repeat(points):
        return given, 0
    number = _numbers(points)
    count, d = int(number.max()) + 1, points.shape[1]
    first = np.full(count, len(points))
    np.minimum.at(first, number, np.arange(len(points)))
    if normals is not None:
        mean = np.column_stack([np.bincount(number, n, count) for n in normals.T])
        length = np.linalg.norm(mean, axis=1)
        agree = length >= AGREEING * np.bincount(number, minlength=count)
        kept = np.sort(np.append(first[agree], np.flatnonzero(~agree[number])))
        which = number[kept]
        normals = np.where(agree[which, None], (mean / np.maximum(length, AGREEING)[:, None])[which], normals[kept])
    else:
        kept = np.sort(first)
    if count < d + 1:
        raise InvalidPointsError(
            f"only {count} of {len(points)} points are distinct: a fit of degree 1 in {d}D needs at least {d + 1}",
            ("points",),
        )
    if len(kept) == len(points):
        return given, 0
    left = np.ascontiguousarray(points[kept])
    return replace(given, points=left, normals=normals, frame=Frame.of(left)), len(points) - len(kept)


def _numbers(points: FloatArray) -> IntArray:
    """Return for each of the points (N, d) the number of its distinct point, (N,)."""
    return np.asarray(np.unique(points + 0.0, axis=0, return_inverse=True)[1].ravel(), dtype=np.intp)  # −0 is 0
