"""A look at a fit on a fine even grid: whether its zero set keeps to the data, and is in one piece.

The zero set cuts the box into regions of one sign. The regions that touch each other form a tree, for a box has no
holes, so the zero set has one component less than there are regions.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.subgrid import specks
from ipcore.points.neighbours import nearest
from ipcore.polynomial import evaluation, univariate
from ipcore.polynomial.univariate import Basis

# Farther than this from all data, in mean radii and in point spacings, the zero set is stray.
FAR_RADII = {2: 0.10, 3: 0.12}
FAR_SPACINGS = 2.5


@dataclass(frozen=True, eq=False)
class Findings:
    """What the grid shows.

    Attributes
    ----------
    f
        Values on the grid.
    minor
        Nodes of all regions but the largest of each sign.
    suspect
        Those, and the nodes far from the data beside which f changes sign.
    specks, speck_values
        (M, d) in the Chebyshev variables, where f has the other sign than all nodes around, and (M,), f there.
    components
        Of the zero set, specks included.
    stray
        Share of the nodes beside a change of sign that are far.

    """

    f: FloatArray
    minor: BoolArray
    suspect: BoolArray
    specks: FloatArray
    speck_values: FloatArray
    components: int
    stray: float


class ViolationGrid:
    """An even grid over the bounds."""

    def __init__(self, sides: InsideOutside, bounds: FloatArray, count: int, reach: float = 1.0) -> None:
        """Take `count` lines per axis, over the bounds (2, d) grown by the factor `reach`."""
        self.lines = reach * np.linspace(-1.0, 1.0, count)
        self._sides, self._shape = sides, (count,) * bounds.shape[1]
        self._middle, self._half = bounds.mean(axis=0), (bounds[1] - bounds[0]) / 2.0
        self._far = max(FAR_RADII[len(self._half)], FAR_SPACINGS * sides.spacing)

    def places(self, mask: BoolArray) -> FloatArray:
        """Return nodes in the Chebyshev variables, (M, d)."""
        return self._at(np.flatnonzero(mask))

    def _at(self, nodes: IntArray) -> FloatArray:
        """Return nodes by their numbers in the row of all: to find these takes a tenth of the time of `np.argwhere`."""
        return self.lines[np.stack(np.unravel_index(nodes, self._shape), axis=1)]

    def local(self, t: FloatArray) -> FloatArray:
        """Return places t (M, d) in the normalised frame."""
        return np.asarray(self._middle + self._half * t)

    def find(self, tensor: FloatArray) -> Findings:
        """Return what is found of the polynomial with these Chebyshev coefficients (n+1, …)."""
        table = univariate.table(Basis.CHEBYSHEV, self.lines, len(tensor) - 1).T
        f = evaluation.along_axes(tensor, [table] * tensor.ndim)
        inside = f < 0.0
        regions, minor = 0, np.zeros_like(inside)
        for part in (inside, ~inside):
            labels, count = ndimage.label(part)
            regions += count
            if count > 1:
                sizes = np.bincount(labels.ravel())
                sizes[0] = 0
                minor |= part & (labels != sizes.argmax())
        beside = _beside_a_change(inside)
        nodes = np.flatnonzero(beside)
        far = np.isinf(nearest(self._sides.tree, self.local(self._at(nodes)), within=self._far)[0])
        suspect = minor.copy()
        suspect.flat[nodes[far]] = True
        small = specks(tensor, self.lines, f, beside)
        components = regions - 1 + len(small[0])
        return Findings(f, minor, suspect, *small, components, float(far.sum() / max(1, len(far))))


def _beside_a_change(inside: BoolArray) -> BoolArray:
    """Return the nodes with a neighbour along an axis of the other sign."""
    beside = np.zeros_like(inside)
    for axis in range(inside.ndim):
        low = tuple(slice(None, -1) if k == axis else slice(None) for k in range(inside.ndim))
        high = tuple(slice(1, None) if k == axis else slice(None) for k in range(inside.ndim))
        change = inside[low] != inside[high]
        beside[low] |= change
        beside[high] |= change
    return beside
