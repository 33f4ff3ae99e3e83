"""The number of connected components of a zero set, of which a grid has found the cells.

Where a part is thinner than a cell of the grid, as the tip of a needle always is, the cells come in pieces that belong
together. So where two components of the cells come near each other, the place between them is looked at on a grid of
its own, as fine as it is thin there: if the zero set connects the two in the box around the place, they are one.
"""

import numpy as np
from scipy.spatial import cKDTree

from ipcore._typing import FloatArray, IntArray
from ipcore.points.neighbours import nearest
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.mesh import labels
from ipcore.zero_set.newton import onto_zero_set
from ipcore.zero_set.refinement import at_resolution
from ipcore.zero_set.thickness import is_thin

GAP_CELLS = 24.0  # the longest gap that is looked at: pieces of a resolved needle 500 : 1 lie up to 12 cells apart
LEAST_MARGIN = 4.0  # cells between the ends of a gap and the walls of the box around it, at least
FINER = (6.0, 24.0)  # grid lines of the box around a gap, per cell of the grid: the second if needed; at most …
FINEST_LOCAL = {2: 2048, 3: 96}  # … along the longest axis
MOST_GAPS = 64  # that are looked at, from the shortest on
MOST_PLACES = 512  # in the box around a gap, of which it is found to which piece of the finer grid they belong
MOST_PIECES = 256  # of more, none are looked at: no thin shape breaks into so many at a resolution that was chosen
BREAK_CELLS = 2.0  # the thickness and the radius of curvature below which a grid may break a zero set

Gap = tuple[float, int, int, FloatArray]  # the distance of two components, their numbers, and the ends (2, d)


def count_components(
    polynomial: ImplicitPolynomial, vertices: FloatArray, cells: IntArray, spacing: float, bounds: FloatArray
) -> int:
    """Return the number of connected components.

    Parameters
    ----------
    polynomial
        f.
    vertices
        (V, d), raw, near f = 0.
    cells
        (C, d), the vertices of segments or triangles; no caps.
    spacing
        The side of a grid cell, raw.
    bounds
        (2, d), the corners of the box, raw.

    """
    used = _used(cells, len(vertices))
    label = labels(cells, len(vertices))[used]
    if (label == label[:1]).all():
        return min(1, len(used))
    x, component = vertices[used], np.unique(label, return_inverse=True)[1]
    group = np.arange(component.max() + 1)
    if len(group) > MOST_PIECES:
        return len(group)
    looks: set[tuple[int, int]] = set()
    for _, first, second, ends in _breaks(polynomial, _gaps(x, component, GAP_CELLS * spacing), spacing, bounds):
        if group[first] == group[second] or (second, first) in looks or len(looks) == MOST_GAPS:
            continue
        looks.add((first, second))
        box = _box_around(ends, LEAST_MARGIN * spacing, bounds)
        there = _within(x, box)
        for lines in FINER:
            local = _pieces(polynomial, x[there], spacing, box, lines)
            _unite(group, component[there], local)
            if group[first] == group[second]:
                break
    return len(np.unique(group))


def _used(cells: IntArray, vertices: int) -> IntArray:
    """Return the vertices (n,) of cells (C, d), in ascending order, given V, `vertices`."""
    used = np.zeros(vertices, dtype=bool)
    used[cells] = True
    return np.flatnonzero(used)


def _unite(group: IntArray, members: IntArray, local: IntArray) -> None:
    """Give one group to those of the components `members` (k,) that are in one piece `local` (k,), which is ≥ 0."""
    for one in np.unique(local[local >= 0]):
        together = group[members[local == one]]
        group[np.isin(group, together)] = together.min()


def _gaps(x: FloatArray, component: IntArray, longest: float) -> list[Gap]:
    """Return the gaps between components: the distance, the numbers of the two, and the ends (2, d); shortest first.

    `component` (n,) says to which component each vertex x (n, d) belongs.
    """
    found = []
    for k in np.argsort(np.bincount(component), kind="stable")[:-1].tolist():
        own = x[component == k]
        within = ((x >= own.min(axis=0) - longest) & (x <= own.max(axis=0) + longest)).all(axis=1)
        others = np.flatnonzero((component != k) & within)
        distance, index = nearest(cKDTree(own), x[others], within=longest)
        order = np.argsort(distance, kind="stable")[: int(np.isfinite(distance).sum())]
        for e in order[np.unique(component[others[order]], return_index=True)[1]].tolist():
            ends = np.stack([own[index[e]], x[others[e]]])
            found.append((float(distance[e]), k, int(component[others[e]]), ends))
    return sorted(found, key=lambda gap: gap[:3])


def _breaks(polynomial: ImplicitPolynomial, gaps: list[Gap], spacing: float, bounds: FloatArray) -> list[Gap]:
    """Return those gaps at which the grid may have broken the zero set: it is thin or sharp at one of the ends."""
    if not gaps:
        return []
    x, normals = onto_zero_set(polynomial, np.concatenate([ends for *_, ends in gaps]), spacing)
    across = np.eye(x.shape[1]) - normals[:, :, None] * normals[:, None, :]
    bending = np.linalg.norm(across @ polynomial.hessian(x) @ across, axis=(1, 2))
    sharp = BREAK_CELLS * spacing * bending > np.linalg.norm(polynomial.gradient(x), axis=1)
    broken = (sharp | is_thin(polynomial, x, normals, BREAK_CELLS * spacing, bounds)).reshape(-1, 2).any(axis=1)
    return [gap for gap, may_break in zip(gaps, broken, strict=True) if may_break]


def _box_around(ends: FloatArray, least: float, bounds: FloatArray) -> FloatArray:
    """Return the box (2, d) around the ends (2, d) of a gap; its walls are a gap's length away, or `least` if more."""
    margin = max(float(np.linalg.norm(ends[1] - ends[0])), least)
    return np.asarray(np.clip([ends.min(axis=0) - margin, ends.max(axis=0) + margin], *bounds))


def _within(x: FloatArray, box: FloatArray) -> IntArray:
    """Return the vertices (k,) of x (n, d) that lie in a box (2, d): of many, those nearest to its middle."""
    within = np.flatnonzero(((x >= box[0]) & (x <= box[1])).all(axis=1))
    order = np.argsort(np.linalg.norm(x[within] - box.mean(axis=0), axis=1), kind="stable")
    return within[order[:MOST_PLACES]]


def _pieces(
    polynomial: ImplicitPolynomial, places: FloatArray, spacing: float, box: FloatArray, lines: float
) -> IntArray:
    """Return for places (k, d) near f = 0 the component of the zero set in a box (2, d) on which they lie, (k,).

    It is −1 where there is none within a cell of the box's own grid.
    """
    none = np.full(len(places), -1)
    if not (box[0] < box[1]).all():
        return none
    wanted = lines * float((box[1] - box[0]).max()) / spacing
    found = at_resolution(polynomial, box, int(min(wanted, FINEST_LOCAL[polynomial.dimension])))
    cells = found.mesh.cells[~found.mesh.cap]
    if not len(cells):
        return none
    used = _used(cells, len(found.mesh.vertices))
    distance, index = nearest(cKDTree(found.mesh.vertices[used]), onto_zero_set(polynomial, places, spacing)[0])
    return np.where(distance <= found.spacing, labels(cells, len(found.mesh.vertices))[used[index]], -1)
