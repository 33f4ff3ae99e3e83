r"""Min-Var (Helzer, Barzohar and Malah, PAMI 2004): the zero set that varies least with the coefficients.

    f(x_i) = 0,    √μ ∇f(x_i) = √μ w_i n_i,    w_i = ‖m(x_i)‖₂

Independent errors of variance ε² in every coefficient move the zero set at x_i with variance
ε² ‖m(x_i)‖₂² / ‖∇f(x_i)‖². All else is as in Min-Max.
"""

from functools import partial

import numpy as np

from ipcore._typing import FloatArray
from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.rows import Rows, gradient_rows, layer_rows
from ipcore.polynomial import graded


class MinVar(Family):
    """f = 0 and ∇f = w n on the data, with w_i proportional to ‖m(x_i)‖₂."""

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
    """Return w_i / mean w, (N,), with w_i = ‖m(x_i)‖₂, for points (N, d) in the normalised frame.

    >>> gradient_length(np.array([[2.0, 2.0], [0.0, 0.0]]), 1).tolist()    # w = √(1 + x² + y²) = 3 and 1
    [1.5, 0.5]
    """
    w = np.sqrt(graded.sum_of_all(points**2, degree))
    return np.asarray(w / w.mean())
