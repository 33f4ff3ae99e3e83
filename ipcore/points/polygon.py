"""Closed polygons through 2D points in order: whether they cross or touch themselves, and which side of an edge is out.

The inside of a polygon that crosses itself, as a figure eight does, is defined by the even-odd rule: a place is inside
if a ray from it meets the polygon an odd number of times.
"""

import numpy as np
from scipy.spatial import cKDTree

from ipcore._typing import BoolArray, FloatArray, IntArray

# Long edges are cut into pieces of this many median lengths, so that only pieces that are near each other are compared.
PIECE_LENGTHS = 2.0
# Above so many edges no sides are computed: the time is that of all pairs, 0.6 s.
MOST_EDGES = 8192
EDGES_TOGETHER = 256  # edges whose sides are computed together: their pairs stay in the cache
PROBE_SHARE = 1e-3  # of an edge's length: the distance of the places beside its middle at which parity is counted


def crosses_itself(p: FloatArray) -> bool:
    """Return whether two edges of the closed polygon p (n, 2) meet elsewhere than at the vertex that they share.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> crosses_itself(square), crosses_itself(square[[0, 2, 1, 3]])
    (False, True)
    """
    steps = np.roll(p, -1, axis=0) - p
    length = np.linalg.norm(steps, axis=1)
    some = length > 0.0
    if not some.any():
        return False
    piece = PIECE_LENGTHS * float(np.median(length[some]))
    pieces = np.maximum(np.ceil(length / piece).astype(np.intp), 1)
    edge = np.repeat(np.arange(len(p)), pieces)
    share = np.arange(len(edge)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    middles = p[edge] + steps[edge] * ((share + 0.5) / pieces[edge])[:, None]
    near = cKDTree(middles).query_pairs(piece * (1.0 + 1e-9), output_type="ndarray")
    i, j = np.unique(np.sort(edge[near], axis=1), axis=0).T if len(near) else np.empty((2, 0), dtype=np.intp)
    apart = (j - i > 1) & (j - i < len(p) - 1) & some[i] & some[j]
    return bool(_meet(p, steps, i[apart], j[apart]).any())


def _meet(p: FloatArray, steps: FloatArray, i: IntArray, j: IntArray) -> BoolArray:
    """Return for pairs of edges i, j (k,) whether they meet: each has the other's ends on both sides, or on itself."""

    def side(edge: IntArray, vertex: IntArray) -> FloatArray:
        offset = p[vertex % len(p)] - p[edge]
        return np.asarray(steps[edge, 0] * offset[:, 1] - steps[edge, 1] * offset[:, 0])

    ends = side(i, j) * side(i, j + 1), side(j, i) * side(j, i + 1)
    straight = (side(i, j) == 0.0) & (side(i, j + 1) == 0.0)  # on one line: they meet if their boxes do
    lower = np.maximum(np.minimum(p[i], p[i] + steps[i]), np.minimum(p[j], p[j] + steps[j]))
    upper = np.minimum(np.maximum(p[i], p[i] + steps[i]), np.maximum(p[j], p[j] + steps[j]))
    return np.asarray(np.where(straight, (lower <= upper).all(axis=1), (ends[0] <= 0.0) & (ends[1] <= 0.0)))


def right_is_outside(p: FloatArray) -> FloatArray:
    """Return for each vertex of the closed polygon p (n, 2) whether the right of its edges is outside, (n,).

    1 if it is, −1 if the left is outside and the right is not, by the even-odd rule. Where both sides are inside or
    both outside, as along a slit, it is 1.

    >>> right_is_outside(np.array([[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]])).tolist()      # a bow tie
    [1.0, -1.0, -1.0, 1.0]
    """
    steps = np.roll(p, -1, axis=0) - p
    if len(p) > MOST_EDGES:
        return np.ones(len(p))
    right = PROBE_SHARE * steps @ np.array([[0.0, -1.0], [1.0, 0.0]])  # row vectors: (x, y) → (y, −x)
    middles = p + steps / 2.0
    edge = _inside(middles - right, p, steps).astype(float) - _inside(middles + right, p, steps).astype(float)
    both = edge + np.roll(edge, 1)
    return np.where(both < 0.0, -1.0, 1.0)


def _inside(places: FloatArray, p: FloatArray, steps: FloatArray) -> BoolArray:
    """Return which places (M, 2) are inside the closed polygon p (n, 2) with these edges, by the even-odd rule."""
    ends = np.roll(p, -1, axis=0)
    rising = np.where(steps[:, 1] == 0.0, 1.0, steps[:, 1])  # an edge along the ray is not crossed; nor …
    out = np.empty(len(places), dtype=np.bool_)
    for start in range(0, len(places), EDGES_TOGETHER):
        x, y = places[start : start + EDGES_TOGETHER].T[:, :, None]
        crossed = (p[:, 1] > y) != (ends[:, 1] > y)
        with np.errstate(over="ignore"):  # … is one that is nearly so, unless y is between its ends
            at = p[:, 0] + ((y - p[:, 1]) / rising) * steps[:, 0]
        out[start : start + EDGES_TOGETHER] = (crossed & (x < at)).sum(axis=1) % 2 == 1
    return out
