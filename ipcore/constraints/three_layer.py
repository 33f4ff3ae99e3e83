r"""The 3L constraints (Blane, Lei and Cooper, PAMI 2000): values of f on the data and on two layers beside it.

    f(x_i) = 0,    f(x_i + c n_i) = +c,    f(x_i − c n_i) = −c

with n_i the unit outward normal, so that f grows outward with ‖∇f‖ ≈ 1 and is negative inside. Any other pair ±b gives
the same zero set; ±c makes f a distance near the data.

A noise-free algebraic shape is not reproduced: its own polynomial is 0 on the data, but not +c and −c all along the
other two layers, unless it is a plane. This bias is the price of a stable sign; Taubin's fit does not have it.
"""

from ipcore._typing import FloatArray
from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.rows import Rows, layer_rows


class ThreeLayer(Family):
    """Three layers, at 0 and ±c."""

    uses_layer_distance = True

    def layer_offsets(self, layer_distance: float) -> tuple[float, ...]:
        """Return the offsets of the layers, which are also the values of f on them, in mean radii."""
        return (0.0, layer_distance, -layer_distance)

    def rows(self, points: FloatArray, normals: FloatArray, parameters: RowParameters) -> Rows:
        """Return the rows for points and unit outward normals, (N, d) each, in the normalised frame.

        >>> import numpy as np
        >>> three = ThreeLayer().rows(np.array([[1.0, 0.0]]), np.array([[1.0, 0.0]]), RowParameters(0.05, 0.0))
        >>> [group.positions.tolist() for group in three.groups], three.b(1).tolist()
        ([[[1.0, 0.0]], [[1.05, 0.0]], [[0.95, 0.0]]], [0.0, 0.05, -0.05])
        """
        return Rows(layer_rows(points, normals, self.layer_offsets(parameters.layer_distance)))

    def rows_per_point(self, dimension: int) -> int:  # noqa: ARG002 - the same in 2D and 3D
        """Return 3, one per layer."""
        return 3
