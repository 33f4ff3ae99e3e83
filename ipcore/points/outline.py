"""Outlines: whether 2D points stand in order along curves, and the normals that this order gives.

Along an outline the tangent is the weighted mean of the nearest steps, and the normal is at right angles to it.
"""

from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree

from ipcore._typing import FloatArray, IntArray
from ipcore.errors import InvalidPointsError
from ipcore.points.neighbours import nearest
from ipcore.points.orientation import outward_signs
from ipcore.points.polygon import crosses_itself, right_is_outside

# The greatest length of the path through an outline's points over that of their tree: on 14 outlines it is 1.00–1.03,
# with noise of ½ spacing 1.15–1.3, of ¾ 1.2–1.5, of one 1.4–1.8.
PATH_RATIO = 1.5
# The same where the path is a closed polygon that does not meet itself: the tree of a shape thinner than the spacing
# runs along both sides at once, so that its length is half that of the path.
THIN_PATH_RATIO = 2.2
TREE_NEIGHBOURS = 8  # with as many neighbours, the ratios above are those of the exact tree to 0.01
JUMP_STEPS = 3.0  # median steps: a longer step leads to the next curve; within a curve it does no harm (see `_pieces`)
# The greatest share of jumps among the steps: an outline has 10 points or more. Of 1,000 random orders of 12 points
# none pass with this limit, 9 without it.
JUMP_SHARE = 0.1
# Weights of the steps next to a point and next but one: the slope of the line fitted to 5 equidistant points. Mean
# cosine to the true normal, on 14 outlines clean, with noise of ¼ and ½ spacing, and on a pixel staircase: 3 points
# 1.000, 0.982, 0.917, 0.93; 5 points 0.994, 0.990, 0.975, 0.98; 7 points 0.988, 0.986, 0.979, 0.99.
STEP_WEIGHTS = (3.0, 2.0)


def is_outline(points: FloatArray) -> bool:
    """Return whether 2D points (N, 2) stand in order along one or several curves.

    A path along a curve is about as long as the points' Euclidean minimum spanning tree, and no path is shorter; a path
    in random order is longer by a factor of about √N. Where the noise exceeds the spacing, the path zigzags and is no
    outline: the neighbours then give better normals than the order. Jumps between curves do not count, unless they are
    many. A shape thinner than the spacing of its points is recognised by its polygon, which does not meet itself.

    >>> zigzag = np.array([[0.0, 0.0], [3.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    >>> is_outline(zigzag), is_outline(np.sort(zigzag, axis=0))
    (False, True)
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if not steps.any():
        return False
    jumps = steps > _jump(steps)
    path = steps.sum() if jumps.mean() > JUMP_SHARE else steps[~jumps].sum()
    ratio = path / _tree_length(points)
    if ratio <= PATH_RATIO:
        return True
    return bool(ratio <= THIN_PATH_RATIO and _is_closed(points, _jump(steps)) and not crosses_itself(points))


def outline_normals(points: FloatArray) -> FloatArray:
    """Return outward normals of 2D points that stand in order along one or several curves.

    Curves may be closed or open and run in either direction. A curve that ends near its start is closed; a step of more
    than 3 spacings from there leads to the next curve. Between open pieces such a step is a straight edge. The inside
    of a closed curve that crosses itself is that of the even-odd rule.

    Parameters
    ----------
    points
        (N, 2), in order. Repeated points share one normal; a closed curve may repeat its first point at the end.

    Returns
    -------
        (N, 2), unit. The normals of an open curve point away from its chord, those of a straight line to either side.

    Raises
    ------
    InvalidPointsError
        If all points are equal.

    Examples
    --------
    >>> outline_normals(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])).round(4).tolist()
    [[-0.7071, -0.7071], [0.7071, -0.7071], [0.7071, 0.7071], [-0.7071, 0.7071]]

    """
    first = np.append(True, (np.diff(points, axis=0) != 0.0).any(axis=1))  # of each run of equal points
    p = points[first]
    if len(p) < 2:
        raise InvalidPointsError("normals need 2 distinct points, not 1", ("points",))
    normals, chords, labels = np.empty_like(p), np.empty_like(p), np.empty(len(p), dtype=np.intp)
    for label, (piece, closed) in enumerate(_pieces(p)):
        normals[piece], chords[piece] = _along(p[piece], closed=closed)
        labels[piece] = label
        if closed and crosses_itself(p[piece]):
            sign = right_is_outside(p[piece])[:, None]
            normals[piece] *= sign
            chords[piece] *= sign
    lengths = np.linalg.norm(chords, axis=1)
    normals *= outward_signs(p, normals, lengths, chords, labels)[:, None]
    return np.asarray(normals[np.cumsum(first) - 1])


def _tree_length(points: FloatArray) -> float:
    """Return the length of the minimum spanning tree of points (N, 2) with edges to near neighbours and along the path.

    That is nearly the Euclidean minimum spanning tree. Without the path's steps the graph may not be connected. (The
    Delaunay triangulation contains the exact tree, but Qhull takes quadratic time for points on a circle.)
    """
    numbers = np.ascontiguousarray(points).view(np.complex128).ravel()  # which are sorted faster than rows
    distinct, order = np.unique(numbers, return_inverse=True)
    p = distinct.view(np.float64).reshape(-1, 2)
    near = nearest(cKDTree(p), p, min(TREE_NEIGHBOURS, len(p) - 1) + 1)[1][:, 1:]
    start = np.concatenate([np.repeat(np.arange(len(p)), near.shape[1]), order[:-1]])
    end = np.concatenate([near.ravel(), order[1:]])
    once = np.unique(np.minimum(start, end) * len(p) + np.maximum(start, end))  # pairs as numbers, to sort them faster
    i, j = np.divmod(once, len(p))
    length = np.linalg.norm(p[i] - p[j], axis=1)
    return float(minimum_spanning_tree(coo_array((length, (i, j)), shape=(len(p), len(p))).tocsr()).sum())


def _jump(steps: FloatArray) -> float:
    """Return the length above which a step leads to the next curve, given the lengths of all steps (n,)."""
    return JUMP_STEPS * float(np.median(steps[steps > 0.0]))


def _pieces(p: FloatArray) -> list[tuple[IntArray, bool]]:
    """Return for each curve the numbers of its points (n,), and whether it is closed.

    The points p (N, 2) are divided at the jumps. The pieces that are then open are one curve: their jumps were long
    straight edges.
    """
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
    jump = _jump(steps)
    ends = [0, *(np.flatnonzero(steps > jump) + 1).tolist(), len(p)]
    runs = [np.arange(a, b) for a, b in pairwise(ends)]
    closed = [_is_closed(p[run], jump) for run in runs]
    pieces = [(run, True) for run, loop in zip(runs, closed, strict=True) if loop]
    if all(closed):
        return pieces
    rest = np.concatenate([run for run, loop in zip(runs, closed, strict=True) if not loop])
    return [*pieces, (rest, _is_closed(p[rest], jump))]


def _is_closed(p: FloatArray, jump: float) -> bool:
    """Return whether a curve p (n, 2) ends near its start: within `jump` and half its length, as a triangle does."""
    gap, length = np.linalg.norm(p[-1] - p[0]), np.linalg.norm(np.diff(p, axis=0), axis=1).sum()
    return len(p) > 2 and bool(gap <= min(jump, 0.5 * length * (1.0 + 1e-9)))


def _along(p: FloatArray, *, closed: bool) -> tuple[FloatArray, FloatArray]:
    """Return the unit normals (n, 2) of one curve p (n, 2), and half of each point's chord, both turned to the right.

    The chord is that from the point before to the point behind. A normal is at right angles to the weighted sum of the
    steps around its point, in which a long step (a straight edge) is shortened to the median: else its direction would
    determine the normals of the points before it, too.
    """
    if closed and (p[0] == p[-1]).all():
        normals, chords = _along(p[:-1], closed=True)
        return np.append(normals, normals[:1], axis=0), np.append(chords, np.zeros((1, 2)), axis=0)
    steps = np.roll(p, -1, axis=0) - p
    if not closed:
        steps[-1] = 0.0
    length = np.linalg.norm(steps, axis=1, keepdims=True)
    median = np.median(length[length > 0.0]) if length.any() else 1.0  # else one point only, between two jumps
    even = steps * (median / np.maximum(length, median))
    even = np.append(
        even, np.zeros((0 if closed else len(STEP_WEIGHTS), 2)), axis=0
    )  # beyond an open end there is no step
    weights = (
        STEP_WEIGHTS if len(p) > 2 * len(STEP_WEIGHTS) else STEP_WEIGHTS[:1]
    )  # so that no step comes in from both sides
    tangent = sum(w * (np.roll(even, -j, axis=0) + np.roll(even, j + 1, axis=0)) for j, w in enumerate(weights))
    tangent = np.asarray(tangent)[: len(p)]
    size = np.linalg.norm(tangent, axis=1, keepdims=True)
    defined = size > 1e-9 * median  # not at a spike without width, where the steps cancel
    tangent = np.where(defined, tangent, np.where(length > 0.0, even[: len(p)], 1.0))
    right = np.array([[0.0, -1.0], [1.0, 0.0]])  # row vectors: (x, y) → (y, −x)
    chords = (steps + np.roll(steps, 1, axis=0)) / 2.0
    return tangent / np.linalg.norm(tangent, axis=1, keepdims=True) @ right, chords @ right
