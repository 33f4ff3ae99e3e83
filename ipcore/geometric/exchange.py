"""Sign constraints for what a grid has found wrong.

Nodes near a suspect that have the wrong sign, or barely the right one, are asked for the right one. A minor region is
either wrong as a whole, or right but cut off where a part of the shape (or of the space beside it) is thinner than the
sides can tell; then the shortest way to the main region of its sign is asked for that sign. If that way leads through
places that are surely on the other side, it is a part of its own, and nothing is wrong. What is too small to tell goes,
and so do specks.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from scipy import ndimage

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.sign_constraints import BEYOND, SignPoints
from ipcore.geometric.violations import Findings, ViolationGrid
from ipcore.polynomial import evaluation

AROUND = 2  # nodes about a suspect that are looked at with it
SLOPE = 0.25  # of the margin, half of that of the grid's nodes: what is asked for late must be possible
MOST = 0.02  # the margin at most
NEARLY, WAYS = 2.0, 20  # cells by which a way may be longer than the shortest, and how many are tried
LITTLE = 0.002  # the margin where no side can be told; all in units of f, whose slope is 1 about

# How far the main region is, and where: see `_to_nearest`.
ToMain = Callable[[], tuple[FloatArray, IntArray]]


@dataclass(frozen=True, eq=False)
class Cuts:
    """Places in the Chebyshev variables (M, d), the side to be had there and its margin (M,)."""

    t: FloatArray
    side: FloatArray
    margin: FloatArray


def cuts(found: Findings, grid: ViolationGrid, sides: InsideOutside) -> Cuts | None:
    """Return what to ask for, or None if nothing is known to be wrong."""
    zone = _grown(found.suspect)
    t, f = grid.places(zone), found.f[zone]
    located = sides.at(grid.local(t))
    side = np.zeros(found.f.shape)
    side[zone] = located.side
    parts = [*_minor(found, side, grid, sides), *_specks(found, grid, sides)]
    if not parts and not bool((located.side * f < 0.0).any()):
        return None
    margin = np.minimum(SLOPE * located.distance, MOST)
    short = (located.side != 0.0) & (located.side * f < margin)
    parts.append(Cuts(t[short], located.side[short], margin[short]))
    joined = [np.concatenate(column) for column in zip(*((p.t, p.side, p.margin) for p in parts), strict=True)]
    return Cuts(*joined)


def _grown(mask: BoolArray) -> BoolArray:
    """Return a mask with the nodes `AROUND` it, by steps along the axes."""
    for _ in range(AROUND):
        grown = mask.copy()
        for axis in range(mask.ndim):
            rows, out = np.moveaxis(mask, axis, 0), np.moveaxis(grown, axis, 0)
            out[1:] |= rows[:-1]
            out[:-1] |= rows[1:]
        mask = grown
    return mask


def _minor(found: Findings, side: FloatArray, grid: ViolationGrid, sides: InsideOutside) -> list[Cuts]:
    """Return what to ask for of each minor region as a whole."""
    out = []
    for sign in (-1.0, 1.0):
        mine = (found.f < 0.0) == (sign < 0.0)
        labels, count = ndimage.label(found.minor & mine)
        nodes = np.flatnonzero(labels)
        which, known = labels.ravel()[nodes], side.ravel()[nodes]
        agreement = np.bincount(which, sign * known, count + 1)
        told = np.bincount(which, known != 0.0, count + 1)
        to_main = cache(partial(_to_nearest, mine & ~found.minor))  # asked for by few, then by some at once
        for k in range(1, count + 1):
            here: BoolArray = labels == k
            if told[k] == 0.0:
                out.append(_asked(grid.places(here), -sign))
            elif agreement[k] > 0.0:
                t = _way(here, to_main, sign, grid, sides)
                if t is not None:
                    out.append(_asked(t, sign))
    return out


def _specks(found: Findings, grid: ViolationGrid, sides: InsideOutside) -> list[Cuts]:
    """Return what to ask for of specks: their side, or that of all around where no side can be told."""
    told = sides.at(grid.local(found.specks)).side
    side = np.where(told == 0.0, -np.sign(found.speck_values), told)
    wrong = side * found.speck_values < 0.0
    return [Cuts(found.specks[wrong], side[wrong], np.full(wrong.sum(), LITTLE))] if wrong.any() else []


def _asked(t: FloatArray, side: float) -> Cuts:
    return Cuts(t, np.full(len(t), side), np.full(len(t), LITTLE))


def _to_nearest(region: BoolArray) -> tuple[FloatArray, IntArray]:
    """Return for each node how far a region is, and which (d, …) of its nodes is the nearest."""
    away, nearest = ndimage.distance_transform_edt(~region, return_indices=True)
    return away, nearest.astype(np.intp)


def _way(here: BoolArray, to_main: ToMain, sign: float, grid: ViolationGrid, sides: InsideOutside) -> FloatArray | None:
    """Return places (M, d) along a shortest way from a region to the main one that is nowhere surely on the wrong side.

    Of the region's nodes that are nearly as near to the main one as the nearest, the first with such a way begins it.
    """
    away, nearest = to_main()
    nodes = np.argwhere(here)
    order = np.argsort(away[here], kind="stable")
    close = order[away[here][order] <= away[here].min() + NEARLY]
    for start in nodes[close[:: max(1, len(close) // WAYS)]]:
        end = nearest[(slice(None), *start)]
        share = np.linspace(0.0, 1.0, 2 * int(np.abs(end - start).max()) + 1)[:, None]
        t = grid.lines[0] + (start + share * (end - start)) * (grid.lines[1] - grid.lines[0])
        if not bool((sides.at(grid.local(t)).side * sign < 0.0).any()):
            return np.asarray(t)
    return None


# Lines per axis, and by what factor the bounds are grown. The first is as fine as the report of the zero set, so that
# the two agree; the second must find nothing, either.
GRIDS = {2: ((240, 1.0), (501, BEYOND)), 3: ((88, 1.0), (129, BEYOND))}
WEIGHT = 0.02  # of each place that is asked for, against a mean squared distance


class Exchange:
    """The grids that a fit has to pass."""

    def __init__(self, sides: InsideOutside, bounds: FloatArray) -> None:
        """Take the sides and the bounds (2, d)."""
        self._sides, self._dimension = sides, bounds.shape[1]
        self._grids = [ViolationGrid(sides, bounds, *grid) for grid in GRIDS[self._dimension]]

    def next_cuts(self, degree: int, a: FloatArray) -> tuple[Findings, SignPoints | None]:
        """Return the findings of the first grid that asks for anything, and what it asks for; else of the last."""
        tensor = evaluation.to_tensor(a, self._dimension, degree)
        for grid in self._grids:
            found = grid.find(tensor)
            suspicious = found.suspect.any() or len(found.specks) > 0
            asked = cuts(found, grid, self._sides) if suspicious else None
            if asked is not None:
                weight = np.full(len(asked.t), WEIGHT)
                return found, SignPoints(asked.t, asked.side, asked.margin, weight)
        return found, None
