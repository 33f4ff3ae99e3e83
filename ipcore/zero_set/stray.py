"""Which part of a zero set is stray: the one rule, for what a report counts and for what a mesh leaves out.

A cell is *far* if its middle is beyond the support radius of the data. Far cells that share vertices form a patch. A
patch is stray, unless it is a gap of the sampling: random points on a closed surface leave holes that are larger than
the support radius, and the surface there is as well supported as around them. A patch is a gap if

- it shares a vertex with cells that are not far, so it is no component of its own,
- all of it is within the gap radius of the data,
- and it leads from one datum to the next, and not away from the data: the directions from its cells to the nearest
  data, weighted by the sizes of the cells, are on average nearer to the tangent than to the normal. This is not asked
  of patches that hardly leave the support: they may be single cells with any direction.

The two radii are those of `support`.
"""

import numpy as np
from scipy.spatial import cKDTree

from ipcore._threads import by_rows
from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.points.neighbours import nearest
from ipcore.polynomial.frame import Frame
from ipcore.zero_set.mesh import cell_middles, cell_vectors, labels
from ipcore.zero_set.support import gap_radius, is_beyond_support, support_radius

# The mean sine of the angle between the tangent and the direction to the nearest datum, above which a patch leads away
# from the data: that of 45°. Patches in samples of 100 to 3,000 random points of eight closed shapes reach 0.61. Single
# cells within 1.04 support radii reach 0.9. The top of a bulge has 1.
STEEPEST = np.sqrt(0.5)
STEEP_REACH = 1.1  # support radii within which a patch hardly leaves the support


def stray_cells(vertices: FloatArray, cells: IntArray, data: FloatArray, threads: int | None = None) -> BoolArray:
    """Return which cells (C, d) of a zero set are stray, (C,).

    Parameters
    ----------
    vertices
        (V, d), in the frame of the data.
    cells
        (C, d), the vertices of segments or triangles; no caps.
    data
        (N, d), N ≥ 2.
    threads
        How many threads work; by default all that are available.

    Examples
    --------
    A circle of radius 1, a datum at each of its vertices but for some, and a circle of radius 2:

    >>> turn = 2.0 * np.pi * np.arange(100) / 100
    >>> ring, around = np.column_stack([np.cos(turn), np.sin(turn)]), np.arange(100)
    >>> cells = np.column_stack([around, np.roll(around, -1)])
    >>> stray = stray_cells(np.vstack([ring, 2.0 * ring]), np.vstack([cells, 100 + cells]), ring[4:])
    >>> stray[:100].any(), stray[100:].all()
    (np.False_, np.True_)

    """
    middle = by_rows(lambda part: cell_middles(vertices, cells[part]), len(cells), threads)
    stray = is_beyond_support(middle, data, threads)
    if stray.any():
        far = np.flatnonzero(stray)
        supported = np.zeros(len(vertices), dtype=bool)
        supported[cells[~stray]] = True
        stray[far] = ~_in_gaps(vertices, cells[far], middle[far], supported, data)
    return stray


def _in_gaps(
    vertices: FloatArray, far: IntArray, middle: FloatArray, supported: BoolArray, data: FloatArray
) -> BoolArray:
    """Return which far cells (F, d) belong to a patch that is a gap of the sampling, (F,).

    `middle` (F, d) are the middles of the cells, `supported` (V,) marks the vertices of cells that are not far.
    """
    patch = np.unique(labels(far, len(vertices))[far[:, 0]], return_inverse=True)[1]
    count = int(patch.max()) + 1
    touches = np.bincount(patch, supported[far].any(axis=1), count) > 0.0
    some = np.flatnonzero(touches[patch])
    distance, index = nearest(cKDTree(data), middle[some], within=gap_radius(data))
    reach = np.zeros(count)
    np.maximum.at(reach, patch[some], distance)
    within = touches & np.isfinite(reach)
    kept = within[patch[some]]
    normal, offset = cell_vectors(vertices, far[some[kept]]), data[index[kept]] - middle[some[kept]]
    across = np.bincount(patch[some[kept]], np.abs(np.einsum("ck,ck->c", normal, offset)), count)
    whole = np.bincount(patch[some[kept]], np.linalg.norm(normal, axis=1) * np.linalg.norm(offset, axis=1), count)
    leads_away = (across > STEEPEST * whole) & (reach > STEEP_REACH * support_radius(data, Frame.of(data).scale))
    return np.asarray((within & ~leads_away)[patch])


def stray_share(vertices: FloatArray, cells: IntArray, stray: BoolArray) -> float | None:
    """Return the share of the length or area of cells (C, d) that is marked in `stray` (C,); None if there is none."""
    size = np.linalg.norm(cell_vectors(vertices, cells), axis=1)
    whole = float(size.sum())
    return float(size[stray].sum()) / whole if whole > 0.0 else None
