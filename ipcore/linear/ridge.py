r"""D of ridge regression, (MᵀM + κD) a = Mᵀb: the weights of the squared coefficients (section 5.3 and the appendix).

    D_αα = γ_s · i! j! (k!) / s!,    γ_s = Σ_t ‖x_t‖^{2s},    s = i + j (+ k)

aᵀDa is then the same however the shape is turned: the multinomial weights make Σ a²·i!j!k!/s! over one form the
rotation-invariant (Bombieri) norm of that form. With D = I, "the simplest choice", it is not.

D is about monomials of the frame. So a ridged fit is computed in monomials, not in Chebyshev products: D would damp a
mixture of their forms, which depends on the shape's box. Each damping row then has one entry, √(κ D_αα) in column α:
when a column is appended no earlier entry of R changes, and the prefix of a ridged fit is the ridged fit of the lower
degree. Monomials cost no accuracy: with columns scaled to length 1 their condition is no worse (a
bird's outline at degree 20: 3e10, Chebyshev products 1e13; the bunny at degree 12: 5e7 and 3e9).

γ_s grows with the number of points as MᵀM does, so with the appendix's D the damping does not depend on how densely the
shape is sampled; with D = I, taken as printed, it does.
"""

from math import factorial, prod

import numpy as np

from ipcore._typing import FloatArray
from ipcore.options.choices import RidgeMatrix
from ipcore.polynomial import graded


def diagonal(matrix: RidgeMatrix, points: FloatArray, degree: int) -> FloatArray:
    """Return the diagonal of D, (m,), in graded order, for points (N, d) in the normalised frame.

    >>> diagonal(RidgeMatrix.INVARIANT, np.array([[2.0, 0.0]]), 2).tolist()      # γ = 1, 4, 16
    [1.0, 4.0, 4.0, 16.0, 8.0, 16.0]
    """
    powers = graded.exponents(points.shape[1], degree)
    if matrix is RidgeMatrix.IDENTITY:
        return np.ones(len(powers))
    s = powers.sum(axis=1)
    squares = (points**2).sum(axis=1)
    gamma = np.array([(squares**k).sum() for k in range(degree + 1)])
    shares = [prod(factorial(p) for p in row) / factorial(sum(row)) for row in powers.tolist()]
    return np.asarray(gamma[s] * np.array(shares))
