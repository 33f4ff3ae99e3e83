"""How much of a zero set strays from the data, and in how many pieces it comes: seen coarsely, without making it.

What `zero_set` says of it too, but for polishing: cells of linear interpolation are as large to some thousandths.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.grid import Grid
from ipcore.zero_set.marching import march_within
from ipcore.zero_set.mesh import cell_vectors, labels
from ipcore.zero_set.support import beyond
from ipcore.zero_set.zero_set import grid_lines

# Grid points along the longest axis of the bounds.
RESOLUTION = {2: 240, 3: 88}


def straying(polynomial: ImplicitPolynomial, data: FloatArray) -> tuple[float, int]:
    """Return the share of the zero set's length or area that is stray, and its number of components in the bounds.

    Stray is what lies beyond the support radius of all data (N, d), raw, N ≥ 2; if there is no zero set, all is.

    >>> from ipcore import shapes
    >>> points, _ = shapes.ellipse().sample(500)
    >>> straying(shapes.ellipse().polynomial, points)
    (0.0, 1)
    """
    axes = grid_lines(polynomial, None, RESOLUTION[polynomial.dimension])
    vertices, cells = march_within(polynomial.on_grid(axes), Grid.of(axes))
    if not len(cells):
        return 1.0, 0
    size = np.linalg.norm(cell_vectors(vertices, cells), axis=1)
    far = beyond(np.add.reduce([vertices[corner] for corner in cells.T]) / cells.shape[1], data)
    return float(size[far].sum() / size.sum()), int(labels(cells, len(vertices)).max()) + 1
