"""Cells of f = 0 from values on a grid: segments in 2D, triangles in 3D, closed along the walls of the box.

Segments come from scikit-image's marching squares, triangles from its marching cubes with the table of Lewiner, Lopes,
Vieira and Tavares (J. Graphics Tools 8(2), 2003), whose topology is right where Lorensen and Cline's is ambiguous. Both
get the grid with one layer of zeros around it, which counts as outside; what comes to lie beyond a wall of the box is
laid onto it, as its cap.
"""

import numpy as np
from skimage.measure import find_contours, marching_cubes

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.mesh import Mesh

# Vertices keep this share of a grid edge from its ends, so that nodes where f = 0 (common: shapes with round numbers)
# do not collapse cells. Any small number does: the error is of the size of linear interpolation's, and polished away.
MARGIN = 0.01
# Marching cubes takes float32 and adds 1e-7 to every value, so values are scaled to 1 and above, and cut at this.
LARGEST = 1e30


def extract(values: FloatArray, axes: list[FloatArray]) -> Mesh:
    """Return the cells of f = 0, given f on the grid of evenly spaced raw grid lines `axes`.

    >>> line = np.linspace(-2.0, 2.0, 5)
    >>> mesh = extract(np.add.outer(line**2, line**2) - 2.5, [line, line])      # the circle cuts 3 · 4 grid edges
    >>> mesh.vertices.shape, mesh.cells.shape, int(mesh.cap.sum())
    ((12, 2), (12, 2), 0)
    """
    padded = _away_from_nodes(np.pad(values, 1))
    index, cells = {2: _segments, 3: _triangles}[values.ndim](padded)
    last = np.array(values.shape) - 1
    beyond: BoolArray = np.any((index < 0) | (index > last), axis=1)
    low: BoolArray = index <= 0
    high: BoolArray = index >= last
    lower, upper = np.array([line[[0, -1]] for line in axes]).T
    inner = lower + index * ((upper - lower) / last)
    vertices = np.where(low, lower, np.where(high, upper, inner))
    cells = _merged(vertices, cells, beyond)
    cap = low[cells].all(axis=1).any(axis=1) | high[cells].all(axis=1).any(axis=1)
    mesh = Mesh(vertices, cells, cap, low | high | beyond[:, None])
    return mesh.keep(np.ones(len(cells), dtype=bool))


def _away_from_nodes(values: FloatArray) -> FloatArray:
    """Return values with the same signs and no zero, whose crossings keep MARGIN from both ends of a grid edge.

    The outermost layer is zero, so no edge crosses from the end of one line to the start of the next, and the grid can
    be read as one long line.
    """
    inside, size, smallest = values.ravel() < 0, np.abs(values.ravel()), np.inf
    for axis in range(values.ndim):
        step = int(np.prod(values.shape[axis + 1 :]))
        a = np.flatnonzero(inside[step:] != inside[:-step])
        b = a + step
        least = MARGIN * (size[a] + size[b])
        size[a], size[b] = np.maximum(size[a], least), np.maximum(size[b], least)
        smallest = min(smallest, size[a].min(initial=np.inf), size[b].min(initial=np.inf))
    size /= smallest
    np.clip(size, 1.0, LARGEST, out=size)
    np.negative(size, out=size, where=inside)
    return size.reshape(values.shape)


def _segments(padded: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return grid indices (V, 2), from −1, and segments (C, 2). The layer of zeros makes every contour a closed one."""
    rings = [ring[:-1] for ring in find_contours(padded, 0.0)]
    if not rings:
        return np.empty((0, 2)), np.empty((0, 2), dtype=np.intp)
    following = np.arange(1, 1 + sum(map(len, rings)))
    lengths = np.array([len(ring) for ring in rings])
    following[np.cumsum(lengths) - 1] -= lengths
    return np.concatenate(rings) - 1.0, np.stack([np.arange(len(following)), following], axis=1)


def _triangles(padded: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return grid indices (V, 3), from −1, and triangles (C, 3)."""
    if padded.min() > 0:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.intp)
    index, cells, _, _ = marching_cubes(padded.astype(np.float32), 0.0)
    return index.astype(np.float64) - 1.0, cells.astype(np.intp)


def _merged(vertices: FloatArray, cells: IntArray, beyond: BoolArray) -> IntArray:
    """Return the cells after what was laid onto the same place of a wall has become one vertex; none degenerate."""
    laid = np.flatnonzero(beyond)
    _, first, inverse = np.unique(vertices[laid], axis=0, return_index=True, return_inverse=True)
    target = np.arange(len(vertices))
    target[laid] = laid[first[inverse.ravel()]]
    cells = target[cells]
    distinct: BoolArray = np.all(cells != np.roll(cells, 1, axis=1), axis=1)
    return np.asarray(cells[distinct])
