"""Segments or triangles of a zero set: where they lie, how large they are, and what hangs together."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ipcore._typing import BoolArray, FloatArray, IntArray

SEGMENT = 2  # corners; a triangle has 3


@dataclass(frozen=True, eq=False)
class Mesh:
    """Segments or triangles, with what is known about the walls of the box.

    Attributes
    ----------
    vertices
        (V, d), raw.
    cells
        (C, d), the vertices of segments (inside on the left) or triangles (counter-clockwise seen from outside).
    cap
        (C,), the cells that lie on a wall and only close the inside.
    held
        (V, d), the coordinates that must stay: the wall's at the rim of a cap, all within a cap.

    """

    vertices: FloatArray
    cells: IntArray
    cap: BoolArray
    held: BoolArray

    def keep(self, cells: BoolArray) -> Self:
        """Return the mesh of some cells (C,) and of the vertices that they use."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.cells[cells]] = True
        renumbered = (np.cumsum(used) - 1)[self.cells[cells]]
        return type(self)(self.vertices[used], renumbered, self.cap[cells], self.held[used])

    def caps_round(self, kept: BoolArray) -> BoolArray:
        """Return the cells (C,) of the caps that have a rim all of whose other cells are `kept` (C,)."""
        if not self.cap.any():
            return self.cap
        label = labels(self.cells[self.cap], len(self.vertices))
        met, lost = np.zeros(len(label), dtype=bool), np.zeros(len(label), dtype=bool)
        met[label[self.cells[kept]]] = True
        lost[label[self.cells[~self.cap & ~kept]]] = True
        return self.cap & (met & ~lost)[label[self.cells[:, 0]]]


def cell_vectors(vertices: FloatArray, cells: IntArray) -> FloatArray:
    """Return the outward normals (C, d) of cells (C, d), as long as the segment or as the triangle is large.

    >>> cell_vectors(np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[0, 1]])).tolist()       # inside: above
    [[0.0, -2.0]]
    """
    origin, *others = (vertices.take(corner, axis=0) for corner in cells.T)  # which takes a fifth of the time of [ ]
    first, *more = ((other - origin).T for other in others)
    out = np.empty(cells.shape)
    if not more:
        out[:, 0], out[:, 1] = first[1], -first[0]
        return out
    (second,) = more
    (x, y, z), (u, v, w) = first, second
    np.subtract(y * w, z * v, out=out[:, 0])
    np.subtract(z * u, x * w, out=out[:, 1])
    np.subtract(x * v, y * u, out=out[:, 2])
    out /= 2.0
    return out


def cell_middles(vertices: FloatArray, cells: IntArray) -> FloatArray:
    """Return the means (C, d) of the corners of cells (C, d).

    >>> cell_middles(np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[0, 1]])).tolist()
    [[1.0, 0.0]]
    """
    total = np.zeros(cells.shape)
    for corner in cells.T:
        total += vertices.take(corner, axis=0)
    total /= cells.shape[1]
    return total


def labels(cells: IntArray, vertices: int) -> IntArray:
    """Return for each vertex (V,) the number of its connected component; a vertex of no cell makes its own.

    >>> labels(np.array([[0, 1], [1, 2], [3, 4]]), 5).tolist()
    [0, 0, 0, 1, 1]
    """
    start, end = cells[:, :-1].ravel(), cells[:, 1:].ravel()
    graph = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(vertices, vertices))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.intp)


def chains(cells: IntArray) -> list[IntArray]:
    """Return the chains of vertices that segments (C, 2) make end to start; a closed one repeats its first vertex.

    >>> [chain.tolist() for chain in chains(np.array([[0, 1], [3, 4], [1, 2], [4, 3]]))]
    [[0, 1, 2], [3, 4, 3]]
    """
    following = dict(cells.tolist())
    entered, found = set(following.values()), []
    for start in sorted(following, key=entered.__contains__):  # open chains from their first vertex, then closed ones
        chain = [start]
        while chain[-1] in following:
            chain.append(following.pop(chain[-1]))
        if len(chain) > 1:
            found.append(np.array(chain))
    return found
