r"""Five layers: 3L with two more half way.

    f(x_i + o n_i) = o,    o = 0, ±c/2, ±c

At high degree f can turn between the three layers of 3L, where no row holds it; D_smooth then falls (on an apple's
outline, 500 points, to 0.39 at degree 18; with five layers it is 0.97). Two more layers at ±2c instead hold it as well
but are farther from the shape, and D_dist is nearly twice as large.
"""

from ipcore._typing import FloatArray
from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.rows import Rows, layer_rows


class FiveLayer(Family):
    """Five layers, at 0, ±c/2 and ±c."""

    uses_layer_distance = True

    def layer_offsets(self, layer_distance: float) -> tuple[float, ...]:
        """Return the offsets of the layers, which are also the values of f on them, in mean radii."""
        return (0.0, layer_distance, -layer_distance, layer_distance / 2.0, -layer_distance / 2.0)

    def rows(self, points: FloatArray, normals: FloatArray, parameters: RowParameters) -> Rows:
        """Return the rows for points and unit outward normals, (N, d) each, in the normalised frame.

        >>> import numpy as np
        >>> FiveLayer().rows(np.array([[1.0, 0.0]]), np.array([[1.0, 0.0]]), RowParameters(0.1, 0.0)).b(1).tolist()
        [0.0, 0.1, -0.1, 0.05, -0.05]
        """
        return Rows(layer_rows(points, normals, self.layer_offsets(parameters.layer_distance)))

    def rows_per_point(self, dimension: int) -> int:  # noqa: ARG002 - the same in 2D and 3D
        """Return 5, one per layer."""
        return 5
