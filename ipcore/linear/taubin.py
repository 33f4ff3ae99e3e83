r"""Taubin's fit: the smallest generalised eigenvector of (Σ m mᵀ, Σ_k ∂_k m ∂_k mᵀ), from the same factorisation.

With [A; G] = QR, A the rows of f and G those of ∇f, and y = R a, the quotient Σ f² / Σ ‖∇f‖² is
‖Q_A y‖² / (‖y‖² − ‖Q_A y‖²): it is least where y is the right singular vector of Q_A with the smallest singular value.
AᵀA and GᵀG are never formed, so a polynomial that vanishes on the data is found to rounding. One that vanishes there
with its gradient, as the square of such a polynomial does, makes a collinear column.
"""

from dataclasses import replace

import numpy as np

from ipcore._typing import FloatArray
from ipcore.linear.dense import DenseFit
from ipcore.polynomial import graded
from ipcore.search.fitter import PrefixFit


class TaubinFit(DenseFit):
    """Minimises Σ f² / Σ ‖∇f‖² over the data."""

    def raise_to(self, alpha: int) -> PrefixFit:
        """Append the columns up to the first α that are still missing, and take the smallest singular vector.

        f is scaled to mean ‖∇f‖² = 1, so that it is about a distance, and grows along the normals.
        """
        self._append(self._factor, alpha)
        points, normals = self._data.points, self._data.normals
        y = _smallest_right_singular_vector([block[: len(points)] for block in self._factor.q_blocks()])
        degree = graded.degree_of(points.shape[1], alpha)
        polynomial = self._data.polynomial(degree, self._factor.solve(y), self._basis)
        f, gradient = polynomial.value_and_gradient(points)
        size = float(np.sqrt((gradient**2).sum(axis=1).mean())) or 1.0  # every column but the constant may be dropped
        size *= 1.0 if (gradient * normals).sum() >= 0.0 else -1.0
        scaled = replace(polynomial, coefficients=polynomial.coefficients / size)
        return self._prefix_fit(scaled, len(points), float(((f / size) ** 2).sum()))


def _smallest_right_singular_vector(blocks: list[FloatArray]) -> FloatArray:
    """Return y (k,) of length 1 with the least ‖[blocks] y‖; blocks (N, …) of k columns in all."""
    if not blocks:
        return np.zeros(0)
    return np.asarray(np.linalg.svd(np.linalg.qr(np.hstack(blocks), mode="r"))[2][-1])
