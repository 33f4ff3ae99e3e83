r"""Min-Var (Helzer, Barzohar and Malah, PAMI 2004): the zero set that varies least with the coefficients.

    f(x_i) = 0,    √μ ∇f(x_i) = √μ w_i n_i,    w_i = ‖m(x_i)‖₂

Independent errors of variance ε² in every coefficient move the zero set at x_i with variance
ε² ‖m(x_i)‖₂² / ‖∇f(x_i)‖². Otherwise as Min-Max.
"""

from functools import partial

import numpy as np

from ipcore._typing import FloatArray
from ipcore.linear.constraints.rows import Rows, gradients, layers
from ipcore.polynomial import graded


def rows(points: FloatArray, normals: FloatArray, weight: float) -> Rows:
    """Return the rows; points and normals (N, d) in the normalised frame, `weight` μ."""
    groups = (*layers(points, normals, (0.0,)), *gradients(points, normals, weight))
    return Rows(groups, partial(gradient_length, points))


def gradient_length(points: FloatArray, degree: int) -> FloatArray:
    """Return w_i / mean w, (N,), with w_i = ‖m(x_i)‖₂.

    >>> gradient_length(np.array([[2.0, 2.0], [0.0, 0.0]]), 1).tolist()    # w = √(1 + x² + y²) = 3 and 1
    [1.5, 0.5]
    """
    w = np.sqrt(graded.sum_of_all(points**2, degree))
    return np.asarray(w / w.mean())
