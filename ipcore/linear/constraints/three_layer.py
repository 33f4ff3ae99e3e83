r"""The 3L constraints (Blane, Lei and Cooper, PAMI 2000): f is asked for on the data and on two layers beside it.

    f(x_i) = 0,    f(x_i + c n_i) = +c,    f(x_i − c n_i) = −c

with n_i the unit outward normal, so that f grows outward with ‖∇f‖ ≈ 1 and is negative inside. Any other pair ±b gives
the same zero set; ±c makes f a distance near the data.

A noise-free algebraic shape is not reproduced: its own polynomial is 0 on the data, but not +c and −c all along the
other two layers, unless it is a plane. 3L buys a stable sign with this bias; Taubin's fit is without it.
"""

from ipcore._typing import FloatArray
from ipcore.linear.constraints.rows import Rows, layers


def offsets(distance: float) -> tuple[float, ...]:
    """Return where the layers lie, in mean radii: what f is asked to be there."""
    return (0.0, distance, -distance)


def rows(points: FloatArray, normals: FloatArray, distance: float) -> Rows:
    """Return the rows of three layers.

    Parameters
    ----------
    points, normals
        (N, d) each, in the normalised frame; normals of length 1, outward.
    distance
        c, in mean radii.

    Examples
    --------
    >>> import numpy as np
    >>> three = rows(np.array([[1.0, 0.0]]), np.array([[1.0, 0.0]]), 0.05)
    >>> [group.positions.tolist() for group in three.groups], three.b(1).tolist()
    ([[[1.0, 0.0]], [[1.05, 0.0]], [[0.95, 0.0]]], [0.0, 0.05, -0.05])

    """
    return Rows(layers(points, normals, offsets(distance)))
