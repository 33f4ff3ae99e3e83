r"""Taubin's constraints (PAMI 1991): no normals, and no right-hand side.

    minimise  Σ f(x_i)² / Σ ‖∇f(x_i)‖²    ⇔    smallest λ of  (Σ m mᵀ) a = λ (Σ_k ∂_k m ∂_k mᵀ) a

The quotient is, to first order, the mean squared distance of the data from the zero set. A polynomial that vanishes on
the data makes it 0, so a noise-free algebraic shape is found exactly, at its own degree. At a higher degree every
multiple of it does so too, and the answer is one of many; nothing then holds the sign of f beside the data.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.linear.constraints.rows import RowGroup, Rows, gradients


def rows(points: FloatArray) -> Rows:
    """Return the rows f(x_i) = 0 and ∇f(x_i) = 0, whose squares are numerator and denominator; points (N, d)."""
    return Rows((RowGroup(points, np.zeros(len(points))), *gradients(points, np.zeros_like(points), 1.0)))
