r"""3L with gradient rows: three layers, and on the data the gradient too.

    f(x_i) = 0,    f(x_i ± c n_i) = ±c,    √μ ∇f(x_i) = √μ n_i

The layers keep the sign of f beside the data, the gradient rows keep f from turning between them.
"""

from ipcore._typing import FloatArray
from ipcore.linear.constraints.rows import Rows, gradients, layers


def rows(points: FloatArray, normals: FloatArray, distance: float, weight: float) -> Rows:
    """Return the rows; points and normals (N, d) in the normalised frame, `distance` c in mean radii, `weight` μ.

    >>> import numpy as np
    >>> rows(np.array([[1.0, 0.0]]), np.array([[0.6, 0.8]]), 0.05, 0.25).b(1).tolist()
    [0.0, 0.05, -0.05, 0.3, 0.4]
    """
    return Rows((*layers(points, normals, (0.0, distance, -distance)), *gradients(points, normals, weight)))
