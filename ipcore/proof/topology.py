"""The number of components of a zero set and its Euler characteristic, from the signs of f at the corners of cells.

The cells are those of an octree (a quadtree in the plane), on each of which the zero set is simple (`regularity`). They
are balanced: neighbours are at most twice as large. Then the mesh that the signs at the corners describe has the
topology of the zero set (Plantinga and Vegter 2007). It need not be made. A vertex lies on each edge whose ends differ
in sign, a segment on each face with two such edges, and each closed chain of segments around a cell bounds one polygon.
The cells beside a face with more such edges are halved: on a part of a cell the zero set is as simple.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ipcore._typing import BoolArray, IntArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.proof.blocks import Blocks
from ipcore.proof.octree import SPARE_HALVINGS, Cells, Faces
from ipcore.proof.rounding import lost_in_rounding

# The corners of a square and the middles of its edges, in order, in halves of its side.
AROUND = np.array([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)])


@dataclass(frozen=True)
class Topology:
    """The number of components, and the Euler characteristic: 0 of a curve, 2 − 2 genus of each closed surface."""

    components: int
    euler: int


def topology(polynomial: ImplicitPolynomial, leaves: list[Blocks]) -> Topology | None:
    """Return the topology of the zero set in these blocks, all regular; f has no zero in others of the box.

    None if nothing can be claimed: the zero set may reach the walls of the box, a sign is lost in rounding, or a face
    stays ambiguous.
    """
    if not leaves:
        return Topology(0, 0)
    if any(blocks.touch_walls().any() for blocks in leaves):
        return None
    cells, signs = Cells.of(leaves), Signs(polynomial)
    for _ in range(SPARE_HALVINGS + 1):
        cells = cells.balanced()
        corners, faces = cells.corners(), Faces.of(cells)
        if not signs.find(cells, corners):
            return None
        around = _around(faces, cells, corners)
        changes = _changes(around, signs.negative)
        ambiguous = changes.sum(axis=1) > 2
        if not ambiguous.any():
            return _counted(faces, *_segments(around, changes, len(corners)))
        cells = cells.split(np.bincount(faces.cell, ambiguous[faces.face], len(cells.low)) > 0.0)
    return None


class Signs:
    """The signs of f at corners of cells, each computed once while the cells get smaller."""

    def __init__(self, polynomial: ImplicitPolynomial) -> None:
        """Begin with no corner."""
        self._polynomial = polynomial
        self._corners = np.zeros(0, dtype=np.int64)
        self.negative = np.zeros(0, dtype=np.bool_)

    def find(self, cells: Cells, corners: IntArray) -> bool:
        """Let `negative` (K,) be where f < 0 of these corners (K,); return whether all the signs are certain."""
        new = ~np.isin(corners, self._corners)
        places = cells.positions(corners[new])
        values = self._polynomial(places)
        negative = np.empty(len(corners), dtype=np.bool_)
        negative[new] = values < 0.0
        negative[~new] = self.negative[np.isin(self._corners, corners)]  # both are sorted
        self._corners, self.negative = corners, negative
        return not lost_in_rounding(self._polynomial, places, values).any()


def _around(faces: Faces, cells: Cells, corners: IntArray) -> IntArray:
    """Return which corners lie around each face, in order, (K, 8).

    Where the middle of an edge is no corner of any cell, the corner before it stands there once more.
    """
    d = faces.low.shape[1]
    at = np.repeat(faces.low[:, None], len(AROUND), axis=1)
    for normal in np.unique(faces.normal):
        some = faces.normal == normal
        for axis, steps in zip((k for k in range(d) if k != normal), AROUND.T, strict=True):
            at[some, :, axis] += faces.side[some, None] // 2 * steps
    keys = cells.keys(at.reshape(-1, d)).reshape(at.shape[:2])
    number = np.minimum(np.searchsorted(corners, keys), len(corners) - 1)
    return np.where(corners[number] == keys, number, np.roll(number, 1, axis=1))


def _changes(around: IntArray, negative: BoolArray) -> BoolArray:
    """Return where f changes its sign from a corner around a face to the next, (K, 8)."""
    return np.asarray(negative[around] != negative[np.roll(around, -1, axis=1)])


def _segments(around: IntArray, changes: BoolArray, corners: int) -> tuple[IntArray, IntArray]:
    """Return the faces (S,) that have a segment, and the two vertices (S, 2) of each, named after their edges."""
    following = np.roll(around, -1, axis=1)
    low, high = np.minimum(around, following)[changes], np.maximum(around, following)[changes]
    return np.flatnonzero(changes.any(axis=1)), (low * corners + high).reshape(-1, 2)


def _counted(faces: Faces, crossed: IntArray, ends: IntArray) -> Topology | None:
    """Return the topology of the mesh with these segments; None if it is not closed."""
    vertices, of_segment = np.unique(ends, return_inverse=True)
    of_segment = of_segment.reshape(-1, 2)
    components = _components(of_segment, len(vertices))
    if faces.low.shape[1] == 2:
        closed = (np.bincount(of_segment.ravel()) == 2).all()
        return Topology(components, 0) if closed else None
    here = np.isin(faces.face, crossed)
    segment = np.searchsorted(crossed, faces.face[here])
    corners_of_polygons = faces.cell[here, None] * len(vertices) + of_segment[segment]
    named, links = np.unique(corners_of_polygons, return_inverse=True)
    polygons = _components(links.reshape(-1, 2), len(named))
    chained = (np.bincount(links.ravel()) == 2).all()
    closed = (np.bincount(segment) == 2).all()
    return Topology(components, len(vertices) - len(crossed) + polygons) if chained and closed else None


def _components(links: IntArray, count: int) -> int:
    """Return the number of components of a graph with `count` nodes and these links (L, 2)."""
    ones = np.ones(len(links), dtype=np.bool_)
    graph = coo_array((ones, links.T), shape=(count, count))
    count, _ = connected_components(graph, directed=False)
    return int(count)
