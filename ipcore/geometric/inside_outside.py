"""On which side of the shape a place lies, how far from the data, and whether that is sure.

The winding number w of the oriented points decides: it is 1 inside and 0 outside of a closed shape. Of an open scan the
two differ by 1 still, but lie elsewhere (½ and −½ on a plane), so the level between them is measured just beside the
data. Far from the data w is smooth, and interpolated from a coarse grid; near them, where the coarse grid and the
nearest normal disagree or either is in doubt, w is computed anew. (Nearest normals alone fail at tips and thin parts.)
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.points import winding
from ipcore.points.neighbours import nearest

REACH = 0.25  # mean radii: farther than this the distance does not matter, and is not searched for
COARSE = {2: 64, 3: 32}  # grid lines per axis; what they miss is near the data, and computed there
SUBSET = 1500  # points that stand for all on the coarse grid: 0.2 s in 3D
PROBES = 300
PAIRS = 2e7  # of places and points at most, where w is computed anew: 0.1 s
# Below this the cosine between the nearest normal and the way to it tells no side, and below half of it the winding
# number's distance from its level does not. With these, no side was wrong farther than 0.025 from 14 outlines, the
# sparse ones included, by the polygon through their points.
STEEP = 0.5
UNSURE = 0.12
# Nearer than this to the data, in mean radii and in local spacings, no side is told: the curve or surface between the
# points is not known that well, and the winding number of single points is not either. Of 0.02 and 0.04 mean radii the
# first keeps thin parts whole (the outlines of bench/QUALITY.md).
NEAR_RADII = 0.02
NEAR_SPACINGS = {2: 0.7, 3: 1.0}
ISOLATED = 3.0  # median spacings: what is farther from its neighbours is no surface, when outliers are expected


@dataclass(frozen=True, eq=False)
class Classification:
    """Places seen from the data.

    Attributes
    ----------
    distance
        (M,), to the nearest point, in mean radii; `REACH` if it is farther.
    side
        (M,), 1 outside, −1 inside, 0 where it is not sure or too near the data.

    """

    distance: FloatArray
    near: FloatArray
    side: FloatArray


class InsideOutside:
    """The sides of oriented points, in the normalised frame.

    Examples
    --------
    >>> turn = 2 * np.pi * np.arange(100) / 100
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn)])
    >>> sides = InsideOutside(circle, circle, np.array([[-1.3, -1.3], [1.3, 1.3]]))
    >>> sides.at(np.array([[0.0, 0.0], [1.0, 0.01], [0.0, 1.2]])).side.tolist()
    [-1.0, 0.0, 1.0]

    """

    def __init__(self, points: FloatArray, normals: FloatArray, bounds: FloatArray) -> None:
        """Take points and unit outward normals (N, d), and the bounds (2, d) that matter."""
        d = points.shape[1]
        self.tree = cKDTree(points)
        self._points, self._normals, self._areas = points, normals, winding.areas(points)
        spacing = self._areas ** (1.0 / (d - 1))
        self.spacing = float(np.median(spacing))
        self._near = np.maximum(NEAR_RADII, NEAR_SPACINGS[d] * spacing)
        self._order = np.random.default_rng(0).permutation(len(points))  # seeded: the same points get the same sides
        self._lower, upper = bounds
        self._cell = (upper - self._lower) / (COARSE[d] - 1)
        lines = [np.linspace(low, high, COARSE[d]) for low, high in bounds.T]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        self._level = self._between()
        self._coarse = self._outward(grid.reshape(-1, d), SUBSET).reshape(grid.shape[:-1])

    def at(self, places: FloatArray) -> Classification:
        """Return what is known of places (M, d)."""
        distance, index = nearest(self.tree, places, within=REACH)
        far = np.isinf(distance)
        outward = map_coordinates(self._coarse, ((places - self._lower) / self._cell).T, order=1, mode="nearest")
        close = np.flatnonzero(~far)
        doubtful = close[self._doubtful(places[close], index[close], distance[close], outward[close])]
        if len(doubtful):
            outward[doubtful] = self._outward(places[doubtful], max(SUBSET, int(PAIRS / len(doubtful))))
        near = np.zeros(len(places))
        near[close] = self._near[index[close]]
        distance[far] = REACH
        sure = (np.abs(outward) > UNSURE) & (distance > near)
        return Classification(distance, near, np.where(sure, np.sign(outward), 0.0))

    def _doubtful(self, places: FloatArray, index: IntArray, distance: FloatArray, outward: FloatArray) -> BoolArray:
        """Return at which places the coarse grid is not to be trusted."""
        along = ((places - self._points[index]) * self._normals[index]).sum(axis=1)
        cosine = along / np.maximum(distance, np.finfo(float).tiny)
        flat = (np.abs(cosine) < STEEP) | (np.abs(outward) < STEEP / 2.0)
        return np.asarray(flat | (np.sign(cosine) != np.sign(outward)))

    def _outward(self, places: FloatArray, count: int) -> FloatArray:
        """Return level − w at places, positive outside, from `count` of the points."""
        return self._level - winding.winding_number(places, *self._thinned(count))

    def _thinned(self, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return `count` of the points, in random order, with their normals and what each then stands for."""
        some = self._order[:count]
        p = self._points[some]
        return p, self._normals[some], winding.areas(p) if count < len(self._points) else self._areas[some]

    def _between(self) -> float:
        """Return the level between the winding numbers on the two sides of the data."""
        p, n, A = self._thinned(SUBSET)
        step = A[:PROBES, None] ** (1.0 / (p.shape[1] - 1)) * n[:PROBES]
        both = np.concatenate([p[:PROBES] - step, p[:PROBES] + step])
        w = winding.winding_number(both, p, n, A).reshape(2, -1).mean(axis=0)
        return float(np.clip(np.median(w), 0.0, 0.5))


def crowded(points: FloatArray) -> BoolArray:
    """Return which points (N, d) have neighbours as near as most have: the others are taken for outliers.

    >>> line = np.column_stack([np.arange(50.0), np.zeros(50)])
    >>> bool(crowded(np.vstack([line, [[20.0, 15.0]]]))[-1]), int(crowded(line).sum())
    (False, 50)
    """
    spacing = winding.areas(points) ** (1.0 / (points.shape[1] - 1))
    return np.asarray(spacing < ISOLATED * np.median(spacing))
