r"""Five layers: 3L with two more half way.

    f(x_i + o n_i) = o,    o = 0, ±c/2, ±c

At high degree f can turn between the three layers of 3L, where nothing holds it; D_smooth then falls (on an apple's
outline, 500 points, to 0.39 at degree 18; with five layers it is 0.97). Two more layers at ±2c instead hold it as well
but are farther from the shape, and D_dist is nearly twice as large.
"""

from ipcore._typing import FloatArray
from ipcore.linear.constraints.rows import Rows, layers


def offsets(distance: float) -> tuple[float, ...]:
    """Return where the layers lie, in mean radii: what f is asked to be there."""
    return (0.0, distance, -distance, distance / 2.0, -distance / 2.0)


def rows(points: FloatArray, normals: FloatArray, distance: float) -> Rows:
    """Return the rows of five layers; points and normals (N, d) in the normalised frame, `distance` c in mean radii.

    >>> import numpy as np
    >>> rows(np.array([[1.0, 0.0]]), np.array([[1.0, 0.0]]), 0.1).b(1).tolist()
    [0.0, 0.1, -0.1, 0.05, -0.05]
    """
    return Rows(layers(points, normals, offsets(distance)))
