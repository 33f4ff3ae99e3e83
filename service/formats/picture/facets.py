"""The triangles of a surface in the order in which they are painted."""

from dataclasses import dataclass
from typing import Self

import numpy as np

import ipcore
from service.formats.picture.plane import Placing

TENTHS = 10.0  # triangles are drawn in whole tenths of a px, which saves their decimal points


@dataclass(frozen=True, eq=False)
class Facets:
    """The visible triangles of a surface, in the order in which they are painted: the farthest first.

    Attributes
    ----------
    corners
        (K, 3, 2), in whole tenths of a px.
    cells
        (K, 3), the numbers of the vertices.
    outside
        (K,), whether the eye sees the outer face.
    depth
        (K,), the coordinate of the middle towards the eye, raw, in ascending order.

    """

    corners: ipcore.IntArray
    cells: ipcore.IntArray
    outside: ipcore.BoolArray
    depth: ipcore.FloatArray

    @classmethod
    def of(cls, cells: ipcore.IntArray, seen: ipcore.FloatArray, place: Placing) -> Self:
        """Return the facets of triangles (C, 3) with vertices (V, 3): coordinates to the right, up and towards the eye.

        If the surface is closed, those that show their inner face are left out: others hide them.
        """
        corners = np.rint(TENTHS * place(seen[:, :2])).astype(np.intp)[cells]
        (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
        turn = bx * ay - ax * by  # counter-clockwise where y is up, clockwise in a picture
        depth = seen[cells, 2].mean(axis=1)
        order = np.argsort(depth, kind="stable")
        order = order[turn[order] > 0 if is_closed(cells) else turn[order] != 0]
        return cls(corners[order], cells[order], turn[order] > 0, depth[order])


def is_closed(cells: ipcore.IntArray) -> bool:
    """Return whether every edge of the triangles (C, 3) belongs to two of them."""
    edges = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())
