"""The search for places where f has the wrong sign, on a grid that is finer than that of the sign constraints.

The zero set should stay near the data and be in one piece. It divides the box into regions in which f has one sign. A
box has no holes, so the regions that touch each other form a tree, and the zero set has one component less than there
are regions.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.subgrid import subgrid_components
from ipcore.points.neighbours import nearest
from ipcore.polynomial import evaluation, univariate
from ipcore.polynomial.box import Box
from ipcore.polynomial.univariate import Basis
from ipcore.zero_set.support import support_radius_of


@dataclass(frozen=True, eq=False)
class Violations:
    """What the grid shows of a polynomial.

    Attributes
    ----------
    tensor
        (n+1, …), the Chebyshev coefficients of the polynomial.
    f
        (N, …), its values on the grid.
    minor
        (N, …), the nodes of all regions but the largest of each sign.
    suspect
        (N, …), the nodes that are minor, or beside a change of sign and beyond the support radius of the data.
    subgrid, subgrid_values
        (M, d), a place within each component that is smaller than a cell, in the Chebyshev variables, and (M,), the
        values of f there.
    components
        The number of components of the zero set, those smaller than a cell included.
    stray
        The share of the nodes beside a change of sign that are beyond the support radius.

    """

    tensor: FloatArray
    f: FloatArray
    minor: BoolArray
    suspect: BoolArray
    subgrid: FloatArray
    subgrid_values: FloatArray
    components: int
    stray: float

    def at(self, t: FloatArray) -> FloatArray:
        """Return the values (M,) of the polynomial at places t (M, d) in the Chebyshev variables."""
        tables = [univariate.table(Basis.CHEBYSHEV, np.ascontiguousarray(x), len(self.tensor) - 1) for x in t.T]
        return np.asarray(evaluation.scattered(self.tensor[None], tables)[0])


class ViolationGrid:
    """An evenly spaced grid over the bounds, on which violations are looked for."""

    def __init__(self, sides: InsideOutside, bounds: FloatArray, count: int) -> None:
        """Take `count` lines per axis, over the bounds (2, d)."""
        d = bounds.shape[1]
        self.lines = np.linspace(-1.0, 1.0, count)
        self._sides, self._shape, self._box = sides, (count,) * d, Box.of(bounds)
        # The mean radius is 1 in the normalised frame. The spacing is that of the areas for which points stand;
        # `zero_set.support` estimates it by the distance to the nearest other point.
        self._support_radius = support_radius_of(d, 1.0, sides.spacing)

    @property
    def cell(self) -> float:
        """Return the longest side of a cell, in mean radii."""
        return float((self.lines[1] - self.lines[0]) * self._box.half.max())

    def places(self, mask: BoolArray) -> FloatArray:
        """Return the nodes of a mask (N, …) in the Chebyshev variables, (M, d)."""
        return self._at(np.flatnonzero(mask))

    def local(self, t: FloatArray) -> FloatArray:
        """Return places t (M, d), given in the Chebyshev variables, in the normalised frame, (M, d)."""
        return self._box.from_cube(t)

    def cube(self, places: FloatArray) -> FloatArray:
        """Return places (M, d) of the normalised frame in the Chebyshev variables, (M, d)."""
        return self._box.to_cube(places)

    def find(self, tensor: FloatArray) -> Violations:
        """Return the violations of the polynomial with the Chebyshev coefficients `tensor` (n+1, …)."""
        table = univariate.table(Basis.CHEBYSHEV, self.lines, len(tensor) - 1).T
        f = evaluation.along_axes(tensor, [table] * tensor.ndim)
        inside = f < 0.0
        minor, regions = _minor_regions(inside)
        beside = _beside_sign_change(inside)
        nodes = np.flatnonzero(beside)
        far = np.isinf(nearest(self._sides.tree, self.local(self._at(nodes)), within=self._support_radius)[0])
        suspect = minor.copy()
        suspect.flat[nodes[far]] = True
        subgrid, values = subgrid_components(tensor, self.lines, f, beside)
        stray = float(far.sum() / max(1, len(far)))
        return Violations(tensor, f, minor, suspect, subgrid, values, regions - 1 + len(subgrid), stray)

    def _at(self, nodes: IntArray) -> FloatArray:
        """Return the Chebyshev variables (M, d) of nodes, given by their numbers (M,) in C order.

        To find these numbers takes a tenth of the time of `np.argwhere`.
        """
        return self.lines[np.stack(np.unravel_index(nodes, self._shape), axis=1)]


def _minor_regions(inside: BoolArray) -> tuple[BoolArray, int]:
    """Return the nodes (N, …) of all regions but the largest of each sign, and the number of regions."""
    regions, minor = 0, np.zeros_like(inside)
    for part in (inside, ~inside):
        labels, count = scipy.ndimage.label(part)
        regions += count
        if count > 1:
            sizes = np.bincount(labels.ravel())
            sizes[0] = 0
            minor |= part & (labels != sizes.argmax())
    return minor, regions


def _beside_sign_change(inside: BoolArray) -> BoolArray:
    """Return the nodes (N, …) that have a neighbour along an axis on the other side; `inside` (N, …) is f < 0."""
    beside = np.zeros_like(inside)
    for axis in range(inside.ndim):
        low = tuple(slice(None, -1) if k == axis else slice(None) for k in range(inside.ndim))
        high = tuple(slice(1, None) if k == axis else slice(None) for k in range(inside.ndim))
        change = inside[low] != inside[high]
        beside[low] |= change
        beside[high] |= change
    return beside
