r"""The 3L constraints (Blane, Lei, Civi and Cooper, PAMI 2000): f is to be 0 on the data and ±c on two offset layers.

    rows at x_i, x_i + c n_i, x_i − c n_i    with b = 0, +c, −c

with n_i the unit outward normal, so that f grows outward with ‖∇f‖ ≈ 1 and is negative inside. Any other pair ±b gives
the same zero set; ±c makes f a distance near the data.
"""

import numpy as np

from ipcore._typing import FloatArray


def layers(points: FloatArray, normals: FloatArray, distance: float) -> tuple[FloatArray, FloatArray]:
    """Return where f is asked for, and what it is to be there.

    Parameters
    ----------
    points, normals
        (N, d) each, in the normalised frame; normals of length 1, outward.
    distance
        c, in mean radii.

    Returns
    -------
        Positions (3N, d) and right-hand side b (3N,).

    Examples
    --------
    >>> positions, b = layers(np.array([[1.0, 0.0]]), np.array([[1.0, 0.0]]), 0.05)
    >>> positions.tolist(), b.tolist()
    ([[1.0, 0.0], [1.05, 0.0], [0.95, 0.0]], [0.0, 0.05, -0.05])

    """
    offset = distance * normals
    positions = np.concatenate([points, points + offset, points - offset])
    return positions, np.repeat([0.0, distance, -distance], len(points))
