r"""Gradient-One (Tasdizen, Tarel and Cooper, IEEE Trans. Image Processing 2000): ∇f is the unit normal on the data.

    f(x_i) = 0,    √μ ∇f(x_i)·n_i = √μ,    √μ ∇f(x_i)·t_i = 0

with t_i the tangent in 2D and two of them in 3D. The gradient equations together are √μ ∇f(x_i) = √μ n_i, which is how
they are written here (see `ipcore.constraints.rows`).
"""

from ipcore._typing import FloatArray
from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.rows import Rows, gradient_rows, layer_rows


class GradientOne(Family):
    """f = 0 and ∇f = n on the data."""

    uses_gradient_weight = True

    def rows(self, points: FloatArray, normals: FloatArray, parameters: RowParameters) -> Rows:
        """Return the rows for points and unit outward normals, (N, d) each, in the normalised frame.

        >>> import numpy as np
        >>> GradientOne().rows(np.array([[1.0, 0.0]]), np.array([[0.6, 0.8]]), RowParameters(0.05, 1.0)).b(1).tolist()
        [0.0, 0.6, 0.8]
        """
        on_the_data = layer_rows(points, normals, (0.0,))
        return Rows((*on_the_data, *gradient_rows(points, normals, parameters.gradient_weight)))

    def rows_per_point(self, dimension: int) -> int:
        """Return 1 + d: one row for f, and one per component of the gradient."""
        return 1 + dimension
