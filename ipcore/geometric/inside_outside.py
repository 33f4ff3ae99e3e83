"""On which side of the shape a place lies, how far from the data it is, and whether that is sure.

The winding number w of the oriented points decides: it is 1 inside and 0 outside of a closed shape. For an open scan
the two sides still differ by 1, but have other values (½ and −½ for a plane), so the level half way between them is
measured just beside the data. Far from the data w is smooth, and interpolated from a coarse grid. Near the data, where
the coarse grid and the nearest normal disagree or one of the two is in doubt, w is computed at the place itself.
(Nearest normals alone give wrong sides at tips and thin parts.)
"""

from dataclasses import dataclass

import numpy as np
import scipy
from scipy.spatial import cKDTree

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.points import winding
from ipcore.points.neighbours import nearest

SEARCH_RADIUS = 0.25  # mean radii: longer distances change nothing in the fit, so they are not searched for
COARSE_LINES = {2: 64, 3: 32}  # of the grid, per axis; what it misses is near the data, where w is computed anyway
COARSE_POINTS = 1500  # points that stand for all on the coarse grid: 0.2 s in 3D
LEVEL_PROBES = 300  # points beside which the level between the two sides is measured
LEAST_JUMP = 0.25  # of w from the inside to the outside, which is 1 at a surface: less is none
WINDING_PAIRS = 2e7  # of places and points at most, where w is computed at the places: 0.1 s
# Below CLEAR_COSINE the cosine between the nearest normal and the direction to it does not tell the side, and below
# half of it the winding number's distance from the level does not. With these, no side was wrong farther than 0.025
# from 14 outlines, the sparse ones included, measured by the polygon through their points.
CLEAR_COSINE = 0.5
UNSURE_WINDING = 0.12  # the side is unsure where w is nearer than this to the level
# Within this radius of the data, in mean radii and in local spacings, the side is unsure: the curve or surface between
# the points is not known that well, and neither is the winding number of single points. Of 0.02 and 0.04 mean radii the
# first keeps thin parts whole (the outlines of bench/QUALITY.md).
BLIND_RADII = 0.02
BLIND_SPACINGS = {2: 0.7, 3: 1.0}
# Neighbours of a point among which one that faces the other way is looked for, and the distance of the tangent from it,
# in spacings, up to which the shape touches itself there.
TOUCHING_NEIGHBOURS, TOUCHING_SPACINGS = {2: 8, 3: 24}, 0.2


@dataclass(frozen=True, eq=False)
class Classification:
    """What is known of M places.

    Attributes
    ----------
    distance
        (M,), to the nearest point, in mean radii; `SEARCH_RADIUS` if it is farther.
    blind_radius
        (M,), the distance from the nearest point up to which the side is unsure, in mean radii; 0 if no point is within
        `SEARCH_RADIUS`.
    side
        (M,), 1 outside, −1 inside, 0 where the side is unsure.

    """

    distance: FloatArray
    blind_radius: FloatArray
    side: FloatArray


class InsideOutside:
    """The inside and the outside of a shape given by oriented points, in the normalised frame.

    Examples
    --------
    >>> turn = 2 * np.pi * np.arange(100) / 100
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn)])
    >>> sides = InsideOutside(circle, circle, np.array([[-1.3, -1.3], [1.3, 1.3]]))
    >>> sides.classify(np.array([[0.0, 0.0], [1.0, 0.01], [0.0, 1.2]])).side.tolist()
    [-1.0, 0.0, 1.0]

    """

    def __init__(self, points: FloatArray, normals: FloatArray, bounds: FloatArray) -> None:
        """Take points and unit outward normals (N, d), and the bounds (2, d) that the coarse grid covers."""
        d = points.shape[1]
        self.tree = cKDTree(points)
        self._points, self._normals, self._areas = points, normals, winding.oriented_areas(points, normals)
        spacing = self._areas ** (1.0 / (d - 1))
        self.spacing = float(np.median(spacing))
        self._blind_radius = np.maximum(BLIND_RADII, BLIND_SPACINGS[d] * spacing)
        self._order = np.random.default_rng(0).permutation(len(points))  # seeded: the same points get the same sides
        self._lower, upper = bounds
        self._cell = (upper - self._lower) / (COARSE_LINES[d] - 1)
        lines = [np.linspace(low, high, COARSE_LINES[d]) for low, high in bounds.T]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        self._level = self._level_between_sides()
        self._coarse = self._outward(grid.reshape(-1, d), COARSE_POINTS).reshape(grid.shape[:-1])

    def classify(self, places: FloatArray) -> Classification:
        """Return side and distance of places (M, d)."""
        distance, index = nearest(self.tree, places, within=SEARCH_RADIUS)
        far = np.isinf(distance)
        outward = scipy.ndimage.map_coordinates(
            self._coarse, ((places - self._lower) / self._cell).T, order=1, mode="nearest"
        )
        close = np.flatnonzero(~far)
        doubtful = close[self._doubtful(places[close], index[close], distance[close], outward[close])]
        if len(doubtful):
            outward[doubtful] = self._outward(places[doubtful], max(COARSE_POINTS, int(WINDING_PAIRS / len(doubtful))))
        blind_radius = np.zeros(len(places))
        blind_radius[close] = self._blind_radius[index[close]]
        distance[far] = SEARCH_RADIUS
        sure = (np.abs(outward) > UNSURE_WINDING) & (distance > blind_radius)
        return Classification(distance, blind_radius, np.where(sure, np.sign(outward), 0.0))

    def side_of_tangent(self, places: FloatArray) -> FloatArray:
        """Return on which side of the tangent at the nearest point places (M, d) are: 1 outside, −1 inside, (M,).

        Within the blind radius, where nothing better is known, it tells a thin part of the shape from a hole in it.
        """
        index = nearest(self.tree, places)[1]
        return np.asarray(np.sign(((places - self._points[index]) * self._normals[index]).sum(axis=1)))

    def touching(self, places: FloatArray) -> BoolArray:
        """Return whether the shape touches itself at the point nearest to each of the places (M, d), (M,).

        It does where the tangent passes through a point that faces the other way, to `TOUCHING_SPACINGS`.
        """
        index = nearest(self.tree, places)[1]
        spacing = self._areas[index] ** (1.0 / (places.shape[1] - 1))
        return np.asarray(self.thickness(places) < TOUCHING_SPACINGS * spacing)

    def thickness(self, places: FloatArray) -> FloatArray:
        """Return how thick the shape, or the gap in it, is at the points nearest to places (M, d), (M,).

        It is the distance of the tangent from the nearest neighbour that faces the other way; infinite where none of
        the `TOUCHING_NEIGHBOURS` does.
        """
        index, around, opposed = self._opposed(places)
        p, n = self._points, self._normals
        height = np.abs(np.einsum("mkd,md->mk", p[around] - p[index, None], n[index]))
        return np.asarray(np.where(opposed, height, np.inf).min(axis=1))

    def middle_of_thin_part(self, places: FloatArray) -> FloatArray:
        """Return for each of the places (M, d) the middle of the thin part there, (M, d), or the place itself.

        It is half way between the nearest point and the nearest of its neighbours that faces the other way.
        """
        index, around, opposed = self._opposed(places)
        other = around[np.arange(len(places)), opposed.argmax(axis=1)]
        middle = (self._points[index] + self._points[other]) / 2.0
        return np.where(opposed.any(axis=1, keepdims=True), middle, places)

    def _opposed(self, places: FloatArray) -> tuple[IntArray, IntArray, BoolArray]:
        """Return the nearest points (M,) of places (M, d), their neighbours (M, k), and which face the other way."""
        index = nearest(self.tree, places)[1]
        k = min(TOUCHING_NEIGHBOURS[places.shape[1]], len(self._points) - 1)
        around = nearest(self.tree, self._points[index], k + 1)[1]
        cosine = np.einsum("mkd,md->mk", self._normals[around], self._normals[index])
        return index, around, np.asarray(cosine < winding.OPPOSED_COSINE)

    def _doubtful(self, places: FloatArray, index: IntArray, distance: FloatArray, outward: FloatArray) -> BoolArray:
        """Return at which places (M, d) the interpolated level − w, `outward` (M,), may have the wrong sign, (M,).

        `index` and `distance` (M,) are those of the nearest point.
        """
        along = ((places - self._points[index]) * self._normals[index]).sum(axis=1)
        cosine = along / np.maximum(distance, np.finfo(float).tiny)
        flat = (np.abs(cosine) < CLEAR_COSINE) | (np.abs(outward) < CLEAR_COSINE / 2.0)
        return np.asarray(flat | (np.sign(cosine) != np.sign(outward)))

    def _outward(self, places: FloatArray, count: int) -> FloatArray:
        """Return level − w at places (M, d), shape (M,): positive outside; w is that of `count` of the points."""
        return self._level - winding.winding_number(places, *self._sample(count))

    def _sample(self, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return `count` random points (n, d), their normals (n, d), and the areas (n,) that each then stands for."""
        some = self._order[:count]
        p = self._points[some]
        n = self._normals[some]
        return p, n, winding.oriented_areas(p, n) if count < len(self._points) else self._areas[some]

    def _level_between_sides(self) -> float:
        """Return the level: the median over points of the mean of w one spacing inside and one spacing outside.

        Where the shape is thinner than a spacing both places are outside, and w does not differ between them: a shape
        that is thin everywhere is taken to be closed.
        """
        p, n, A = self._sample(COARSE_POINTS)
        step = A[:LEVEL_PROBES, None] ** (1.0 / (p.shape[1] - 1)) * n[:LEVEL_PROBES]
        both = np.concatenate([p[:LEVEL_PROBES] - step, p[:LEVEL_PROBES] + step])
        w = winding.winding_number(both, p, n, A).reshape(2, -1)
        if np.median(w[0] - w[1]) < LEAST_JUMP:
            return winding.SURFACE_WINDING
        return float(np.clip(np.median(w.mean(axis=0)), 0.0, 0.5))
