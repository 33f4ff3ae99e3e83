"""The stray share of a zero set and its number of components, measured without making the mesh.

They are those of `zero_set` but for Newton's method, which changes the sizes of the cells by some thousandths.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.grid import Grid, grid_lines
from ipcore.zero_set.marching import march_open
from ipcore.zero_set.mesh import cell_vectors, labels
from ipcore.zero_set.support import is_stray

# Grid points along the longest axis of the bounds; a fit is checked on a grid as fine, see `geometric.exchange`.
STRAY_RESOLUTION = {2: 240, 3: 88}


def straying(polynomial: ImplicitPolynomial, data: FloatArray) -> tuple[float, int]:
    """Return the stray share of the zero set's length or area in the bounds, and its number of components there.

    The stray share is that beyond the support radius of the data (N, d), raw, N ≥ 2; it is 1 if there is no zero set.

    >>> from ipcore import shapes
    >>> points, _ = shapes.ellipse().sample(500)
    >>> straying(shapes.ellipse().polynomial, points)
    (0.0, 1)
    """
    axes = grid_lines(polynomial, None, STRAY_RESOLUTION[polynomial.dimension])
    vertices, cells = march_open(polynomial.on_grid(axes), Grid.of(axes))
    if not len(cells):
        return 1.0, 0
    size = np.linalg.norm(cell_vectors(vertices, cells), axis=1)
    far = is_stray(np.add.reduce([vertices[corner] for corner in cells.T]) / cells.shape[1], data)
    return float(size[far].sum() / size.sum()), int(labels(cells, len(vertices)).max()) + 1
