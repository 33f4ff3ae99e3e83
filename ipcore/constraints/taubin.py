r"""Taubin's constraints (PAMI 1991): no normals, and no right-hand side.

    minimise  Σ f(x_i)² / Σ ‖∇f(x_i)‖²    ⇔    smallest λ of  (Σ m mᵀ) a = λ (Σ_k ∂_k m ∂_k mᵀ) a

The quotient is, to first order, the mean squared distance of the data from the zero set. A polynomial that vanishes on
the data makes it 0, so a noise-free algebraic shape is found exactly, at its own degree. At a higher degree every
multiple of it does so too, and the answer is one of many; no equation then holds the sign of f beside the data.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.rows import RowGroup, Rows, gradient_rows


class Taubin(Family):
    """f and ∇f on the data, whose sums of squares are the numerator and the denominator of the quotient."""

    is_least_squares = False

    def rows(
        self,
        points: FloatArray,
        normals: FloatArray,  # noqa: ARG002 - the family does without
        parameters: RowParameters,  # noqa: ARG002 - the family does without
    ) -> Rows:
        """Return the rows f(x_i) = 0, then ∂_k f(x_i) = 0 for every axis; points (N, d) in the normalised frame."""
        return Rows((RowGroup(points, np.zeros(len(points))), *gradient_rows(points, np.zeros_like(points), 1.0)))

    def rows_per_point(self, dimension: int) -> int:
        """Return 1 + d: one row for f, and one per component of the gradient."""
        return 1 + dimension
