"""Cuts: the sign constraints that remove the violations which a grid has found.

Three kinds of violation get cuts.

- Nodes near a suspect node where f has the wrong sign, or the right one with too little margin: the right sign there.
- Minor regions. A minor region is either wrong as a whole, or it is right but cut off from the main region of its sign,
  where a part of the shape (or of the space beside it) is thinner than the blind radius. A region that is right is
  joined: the shortest path to the main region gets its sign. If every such path leads through places that are surely on
  the other side, the region is a part of its own, and no violation. Nor is it one if f keeps its sign along the path:
  then the region is joined already, by a part thinner than a cell; or if the shape touches itself there. A region
  within the blind radius, where no side is known, is right if it is on its side of the tangents at the nearest points;
  else it gets the other sign.
- Components smaller than a cell: the known side of their place, or that of the nearest tangent if no side is known.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
import scipy

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.violations import ViolationGrid, Violations

# Tuned on the shapes of bench/QUALITY.md, see `ipcore.geometric.fit`. Margins are in units of f, whose slope near the
# data is 1 per mean radius.
SUSPECT_GROWTH = 2  # nodes around a suspect node that are examined with it
CUT_SLOPE = 0.25  # margin per distance, half of that of the grid's nodes: late constraints must be possible to meet
LARGEST_CUT_MARGIN = 0.02
UNKNOWN_SIDE_MARGIN = 0.002  # where no side is known
VISIBLE_CELLS = 1.0  # a part of the shape that is thicker is visible on a grid, in one piece
PATH_SLACK, PATH_TRIALS = 2.0, 20  # cells by which a path may exceed the shortest, and the number of paths tried

# Returns the distance of every node to the main region, in cells, and its nearest node there: see `_to_nearest`.
ToMain = Callable[[], tuple[FloatArray, IntArray]]


@dataclass(frozen=True, eq=False)
class Cuts:
    """M sign constraints: places t (M, d) in the Chebyshev variables, the side (M,) of each and its margin (M,)."""

    t: FloatArray
    side: FloatArray
    margin: FloatArray


def cuts(found: Violations, grid: ViolationGrid, sides: InsideOutside) -> Cuts | None:
    """Return the cuts that remove the violations, or None if nothing is known to be wrong."""
    zone = _grown(found.suspect)
    t, f = grid.places(zone), found.f[zone]
    located = sides.classify(grid.local(t))
    side = np.zeros(found.f.shape)
    side[zone] = located.side
    parts = [*_region_cuts(found, side, grid, sides), *_subgrid_cuts(found, grid, sides)]
    if not parts and not bool((located.side * f < 0.0).any()):
        return None
    margin = np.minimum(CUT_SLOPE * located.distance, LARGEST_CUT_MARGIN)
    short = (located.side != 0.0) & (located.side * f < margin)
    parts.append(Cuts(t[short], located.side[short], margin[short]))
    joined = [np.concatenate(column) for column in zip(*((p.t, p.side, p.margin) for p in parts), strict=True)]
    return Cuts(*joined)


def _grown(mask: BoolArray) -> BoolArray:
    """Return a mask (N, …) with the nodes that are up to `SUSPECT_GROWTH` steps along the axes away from it."""
    for _ in range(SUSPECT_GROWTH):
        grown = mask.copy()
        for axis in range(mask.ndim):
            rows, out = np.moveaxis(mask, axis, 0), np.moveaxis(grown, axis, 0)
            out[1:] |= rows[:-1]
            out[:-1] |= rows[1:]
        mask = grown
    return mask


def _region_cuts(found: Violations, side: FloatArray, grid: ViolationGrid, sides: InsideOutside) -> list[Cuts]:
    """Return the cuts that remove minor regions or join them; `side` (N, …) is the known side of the nodes, or 0."""
    out = []
    for sign in (-1.0, 1.0):
        same_sign = (found.f < 0.0) == (sign < 0.0)
        labels, count = scipy.ndimage.label(found.minor & same_sign)
        nodes = np.flatnonzero(labels)
        label, known = labels.ravel()[nodes], side.ravel()[nodes]
        agreement = np.bincount(label, sign * known, count + 1)
        nodes_with_side = np.bincount(label, known != 0.0, count + 1)
        to_main = cache(partial(_to_nearest, same_sign & ~found.minor))  # few regions need it; then often several do
        for k in range(1, count + 1):
            region: BoolArray = labels == k
            if nodes_with_side[k] == 0.0 and _is_undecided(region, grid, sides):
                continue
            if nodes_with_side[k] == 0.0 and not _agrees_with_tangents(region, sign, grid, sides):
                out.append(_uniform_cuts(grid.places(region), -sign))
            elif nodes_with_side[k] == 0.0 or agreement[k] > 0.0:
                t = _path_to_main(region, to_main, sign, grid, sides)
                if t is not None and _is_blocked(t, sign, found, grid, sides):
                    out.append(_uniform_cuts(t, sign))
    return out


def _is_undecided(region: BoolArray, grid: ViolationGrid, sides: InsideOutside) -> bool:
    """Return whether the shape touches itself near a region (N, …): the nearest tangent then tells nothing."""
    return bool(sides.touching(grid.local(grid.places(region))).any())


def _agrees_with_tangents(region: BoolArray, sign: float, grid: ViolationGrid, sides: InsideOutside) -> bool:
    """Return whether most nodes of a region (N, …) are on the side `sign` of the tangents at the nearest points."""
    return bool((sign * sides.side_of_tangent(grid.local(grid.places(region)))).sum() > 0.0)


def _is_blocked(t: FloatArray, sign: float, found: Violations, grid: ViolationGrid, sides: InsideOutside) -> bool:
    """Return whether f has the other sign than `sign` somewhere on a path t (M, d) where the shape has room for it.

    Where the path leaves a thin part that bends, the middle of the part counts in its place. Where the shape touches
    itself, as two discs do, there is no room: the places on both sides are regions of their own. Where the shape itself
    is not thin, the grid must show that the path is open, for a fit with a neck thinner than that misses the shape.
    """
    if sides.thickness(grid.local(t)).min() > VISIBLE_CELLS * grid.cell:
        return True
    other = t[sign * found.at(t) < 0.0]
    if not len(other):
        return False
    middle = sides.middle_of_thin_part(grid.local(other))
    return bool((sign * found.at(grid.cube(middle)) < 0.0).any()) and not sides.touching(grid.local(other)).any()


def _subgrid_cuts(found: Violations, grid: ViolationGrid, sides: InsideOutside) -> list[Cuts]:
    """Return the cuts that remove components smaller than a cell, as a list of one, or of none."""
    if not len(found.subgrid):
        return []
    places = grid.local(found.subgrid)
    known = sides.classify(places).side
    tangent = np.where(sides.touching(places), 0.0, sides.side_of_tangent(places))
    side = np.where(known == 0.0, tangent, known)
    wrong = side * found.subgrid_values < 0.0
    return [Cuts(found.subgrid[wrong], side[wrong], np.full(wrong.sum(), UNKNOWN_SIDE_MARGIN))] if wrong.any() else []


def _uniform_cuts(t: FloatArray, side: float) -> Cuts:
    """Return cuts with the same side at all places t (M, d), with the margin of an unknown side."""
    return Cuts(t, np.full(len(t), side), np.full(len(t), UNKNOWN_SIDE_MARGIN))


def _to_nearest(region: BoolArray) -> tuple[FloatArray, IntArray]:
    """Return for each node its distance to a region (N, …), in cells, (N, …), and the nearest node, (d, N, …)."""
    away, nearest = scipy.ndimage.distance_transform_edt(~region, return_indices=True)
    return away, nearest.astype(np.intp)


def _path_to_main(
    region: BoolArray, to_main: ToMain, sign: float, grid: ViolationGrid, sides: InsideOutside
) -> FloatArray | None:
    """Return places (M, d) on a straight path from a region (N, …) to the main region of its sign, or None.

    No place on the path is surely on the other side. Paths begin at those nodes of the region that are nearly as near
    to the main region as the nearest one is; the first path that qualifies is returned.
    """
    away, nearest = to_main()
    nodes = np.argwhere(region)
    order = np.argsort(away[region], kind="stable")
    close = order[away[region][order] <= away[region].min() + PATH_SLACK]
    for start in nodes[close[:: max(1, len(close) // PATH_TRIALS)]]:
        end = nearest[(slice(None), *start)]
        share = np.linspace(0.0, 1.0, 2 * int(np.abs(end - start).max()) + 1)[:, None]
        t = grid.lines[0] + (start + share * (end - start)) * (grid.lines[1] - grid.lines[0])
        if not bool((sides.classify(grid.local(t)).side * sign < 0.0).any()):
            return np.asarray(t)
    return None
