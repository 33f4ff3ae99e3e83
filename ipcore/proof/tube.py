"""The tube: the space near the data, a union of balls about them, in which a zero set is supported."""

import numpy as np
from scipy.spatial import cKDTree

from ipcore._typing import BoolArray, FloatArray
from ipcore.points.neighbours import nearest
from ipcore.proof.blocks import Blocks
from ipcore.zero_set.support import SUPPORT_SPACINGS, gap_radius, support_radius

# The density of the data at a datum follows from the distance to the neighbour of this number.
NEIGHBOUR = 6
# Of the nearest data, how many are asked whether their ball holds a block: next to a sparse part of the data the
# nearest has the larger ball, mostly.
ASKED = 4


class Tube:
    """Balls about the data: a place is in the tube if any ball holds it.

    Their radius is the support radius of the data or, if that is more, their gap radius (`zero_set.support`): a random
    sample leaves gaps, which a zero set crosses. Where data are sparser still, it is 2.5 times the spacing around them.
    """

    def __init__(self, points: FloatArray, scale: float = 1.0) -> None:
        """Take the data (N, d), of mean radius `scale`."""
        self._tree = cKDTree(points)
        local = SUPPORT_SPACINGS * spacing(points, self._tree)
        self._radii = np.maximum(max(support_radius(points, scale), gap_radius(points)), local)
        self.radius = float(self._radii.max())
        self._asked = min(ASKED, len(points))

    def holds(self, blocks: Blocks) -> BoolArray:
        """Return which blocks are wholly in one ball, (B,)."""
        away, datum = nearest(self._tree, blocks.middle, self._asked)
        found = np.minimum(datum, len(self._radii) - 1)  # of places at infinity none is nearest
        return np.asarray((away + blocks.radius <= self._radii[found]).any(axis=1))

    def reach(self, blocks: Blocks) -> float:
        """Return a distance within which every place of the blocks has a datum."""
        return float(nearest(self._tree, blocks.middle)[0].max()) + blocks.radius

    def misses(self, blocks: Blocks) -> BoolArray:
        """Return which blocks are wholly farther from all data than the radius of the largest ball, (B,)."""
        return np.asarray(nearest(self._tree, blocks.middle)[0] - blocks.radius > self.radius)


def spacing(points: FloatArray, tree: cKDTree) -> FloatArray:
    """Return the spacing of points (N, d) around each, (N,): the side of a square, or the step, that each stands for.

    The k-th neighbour of a point on a curve is k/2 steps away, on a surface √(k/π).
    """
    k = min(NEIGHBOUR, len(points) - 1)
    away = nearest(tree, points, k + 1)[0][:, k]
    return np.asarray(away * (2.0 / k if points.shape[1] == 2 else np.sqrt(np.pi / k)))
