r"""3L with gradient rows: three layers, and the gradient on the data.

    f(x_i) = 0,    f(x_i ± c n_i) = ±c,    √μ ∇f(x_i) = √μ n_i

The layers keep the sign of f beside the data, the gradient rows keep f from turning between them.
"""

from ipcore._typing import FloatArray
from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.rows import Rows, gradient_rows, layer_rows


class ThreeLayerGradient(Family):
    """Three layers, at 0 and ±c, and ∇f = n on the data."""

    uses_layer_distance = True
    uses_gradient_weight = True

    def rows(self, points: FloatArray, normals: FloatArray, parameters: RowParameters) -> Rows:
        """Return the rows for points and unit outward normals, (N, d) each, in the normalised frame.

        >>> import numpy as np
        >>> rows = ThreeLayerGradient().rows(np.array([[1.0, 0.0]]), np.array([[0.6, 0.8]]), RowParameters(0.05, 0.25))
        >>> rows.b(1).tolist()
        [0.0, 0.05, -0.05, 0.3, 0.4]
        """
        c = parameters.layer_distance
        layers = layer_rows(points, normals, (0.0, c, -c))
        return Rows((*layers, *gradient_rows(points, normals, parameters.gradient_weight)))

    def rows_per_point(self, dimension: int) -> int:
        """Return 3 + d: one row per layer, and one per component of the gradient."""
        return 3 + dimension
