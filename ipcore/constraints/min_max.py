r"""Min-Max (Helzer, Barzohar and Malah, PAMI 2004): the zero set least sensitive to errors of the coefficients.

    f(x_i) = 0,    √μ ∇f(x_i) = √μ w_i n_i,    w_i = ‖m(x_i)‖₁

An error of up to ε in every coefficient moves the zero set at x_i by up to ε ‖m(x_i)‖₁ / ‖∇f(x_i)‖. With the gradient
that long, the bound is the same everywhere, so the largest is as small as it can be. m(x) are the monomials of the
frame up to the degree of the fit, so w depends on the degree, and with it b, but not M: the factorisation grows as for
other families, and b̃ = Qᵀb is computed anew at each degree. The w_i are divided by their mean, which changes no zero
set and makes f a distance on the average.
"""

from functools import partial

import numpy as np

from ipcore._typing import FloatArray
from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.rows import Rows, gradient_rows, layer_rows
from ipcore.polynomial import graded


class MinMax(Family):
    """f = 0 and ∇f = w n on the data, with w_i proportional to ‖m(x_i)‖₁."""

    rhs_depends_on_degree = True
    uses_gradient_weight = True

    def rows(self, points: FloatArray, normals: FloatArray, parameters: RowParameters) -> Rows:
        """Return the rows for points and unit outward normals, (N, d) each, in the normalised frame."""
        on_the_data = layer_rows(points, normals, (0.0,))
        groups = (*on_the_data, *gradient_rows(points, normals, parameters.gradient_weight))
        return Rows(groups, partial(gradient_length, points))

    def rows_per_point(self, dimension: int) -> int:
        """Return 1 + d: one row for f, and one per component of the gradient."""
        return 1 + dimension


def gradient_length(points: FloatArray, degree: int) -> FloatArray:
    """Return w_i / mean w, (N,), with w_i = ‖m(x_i)‖₁, for points (N, d) in the normalised frame.

    >>> gradient_length(np.array([[1.0, 1.0], [0.0, 0.0]]), 1).tolist()    # w = |1| + |x| + |y| = 3 and 1
    [1.5, 0.5]
    """
    w = graded.sum_of_all(np.abs(points), degree)
    return np.asarray(w / w.mean())
