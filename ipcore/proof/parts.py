"""Blocks that touch each other, taken together."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Self

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ipcore._typing import FloatArray, IntArray
from ipcore.proof.blocks import Blocks


@dataclass(frozen=True, eq=False)
class Parts:
    """M blocks in P parts, each of which is in one piece.

    Attributes
    ----------
    middle
        (M, d), the middles of the blocks.
    part
        (M,), the part to which each belongs.
    centre, radius
        (P, d) and (P,), a ball that covers each part.

    """

    middle: FloatArray
    part: IntArray
    centre: FloatArray
    radius: FloatArray

    @classmethod
    def of(cls, some: list[Blocks], dimension: int) -> Self:
        """Return the parts of blocks of this dimension: two touch if the balls about them do."""
        middle = np.concatenate([np.zeros((0, dimension)), *(blocks.middle for blocks in some)])
        reach = np.repeat([blocks.radius for blocks in some], [len(blocks) for blocks in some])
        links = np.concatenate([np.zeros((0, 2), dtype=np.intp), *_touching(middle, reach)])
        graph = coo_array((np.ones(len(links), dtype=np.bool_), links.T), shape=(len(middle),) * 2)
        count, part = connected_components(graph, directed=False)
        sizes = np.bincount(part, minlength=count)[:, None]
        centre = np.stack([np.bincount(part, column, count) for column in middle.T], axis=1) / sizes
        radius = np.zeros(count)
        np.maximum.at(radius, part, np.linalg.norm(middle - centre[part], axis=1) + reach)
        return cls(middle, part.astype(np.intp), centre, radius)


def _touching(middle: FloatArray, reach: FloatArray) -> Iterator[IntArray]:
    """Yield pairs (K, 2) of balls that touch, those of two sizes at a time: else small ones had too many near them."""
    sizes = [np.flatnonzero(reach == one) for one in np.unique(reach)]
    trees = [cKDTree(middle[some]) for some in sizes]
    for (one, tree), (other, larger) in combinations_with_replacement(zip(sizes, trees, strict=True), 2):
        near = tree.sparse_distance_matrix(larger, reach[one[0]] + reach[other[0]], output_type="ndarray")
        yield np.column_stack([one[near["i"]], other[near["j"]]])
