r"""Gradient-One (Tasdizen, Tarel and Cooper, IEEE Trans. Image Processing 2000): ∇f is the unit normal on the data.

    f(x_i) = 0,    √μ ∇f(x_i)·n_i = √μ,    √μ ∇f(x_i)·t_i = 0

with t_i the tangent in 2D and two of them in 3D. The two gradient equations together are √μ ∇f(x_i) = √μ n_i, which is
how they are written here (see `rows`).
"""

from ipcore._typing import FloatArray
from ipcore.linear.constraints.rows import Rows, gradients, layers


def rows(points: FloatArray, normals: FloatArray, weight: float) -> Rows:
    """Return the rows; points and normals (N, d) in the normalised frame, `weight` μ.

    >>> import numpy as np
    >>> rows(np.array([[1.0, 0.0]]), np.array([[0.6, 0.8]]), 1.0).b(1).tolist()
    [0.0, 0.6, 0.8]
    """
    return Rows((*layers(points, normals, (0.0,)), *gradients(points, normals, weight)))
