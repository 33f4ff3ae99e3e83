"""The two families of univariate functions whose products span the polynomials: powers, and Chebyshev polynomials.

Fits are computed in Chebyshev products on the bounds of the fit, which stay within ±1 there at any degree. Results are
given in monomials of the frame, which are easy to evaluate anywhere. Both are graded, so both span the same spaces.
"""

from enum import StrEnum
from functools import lru_cache

import numpy as np

from ipcore._typing import ExtendedArray, FloatArray


class Basis(StrEnum):
    """The univariate functions whose products are the terms of a polynomial."""

    MONOMIAL = "monomial"
    CHEBYSHEV = "chebyshev"


def table(basis: Basis, t: FloatArray, degree: int) -> FloatArray:
    """Return the functions of degree 0…n at t (N,), shape (n+1, N).

    >>> table(Basis.CHEBYSHEV, np.array([0.5]), 3)[:, 0].tolist()
    [1.0, 0.5, -0.5, -1.0]
    """
    values = np.empty((degree + 1, len(t)))
    values[0] = 1.0
    if degree:
        values[1] = t
    known = min(degree, 1)
    while known < degree:  # the highest known one times those below it gives as many again
        some = min(known, degree - known)
        new = values[known + 1 : known + some + 1]
        np.multiply(values[1 : some + 1], values[known], out=new)
        if basis is Basis.CHEBYSHEV:  # T_{m+j} = 2 T_m T_j − T_{m−j}
            new *= 2.0
            new -= values[known - some : known][::-1]
        known += some
    return values


@lru_cache(maxsize=64)
def differentiation(basis: Basis, degree: int) -> FloatArray:
    """Return D, (n+1, n+1), read-only: if a are the coefficients of a univariate polynomial, D a are its derivative's.

    >>> differentiation(Basis.MONOMIAL, 2) @ np.array([5.0, 3.0, 1.0])      # (5 + 3t + t²)' = 3 + 2t
    array([3., 2., 0.])
    """
    D = np.zeros((degree + 1, degree + 1))
    if basis is Basis.MONOMIAL:
        D[np.arange(degree), np.arange(1, degree + 1)] = np.arange(1, degree + 1)
    else:
        for k in range(1, degree + 1):  # T_k' = 2k (T_{k−1} + T_{k−3} + …), the term in T_0 halved
            D[k - 1 :: -2, k] = 2.0 * k
        D[0] /= 2.0
    D.setflags(write=False)
    return D


def chebyshev_to_powers(degree: int, slope: float, offset: float) -> ExtendedArray:
    """Return K, (n+1, n+1): T_k(slope·u + offset) = Σ_j K[j, k] u^j.

    It is computed in extended precision where the platform has it: the entries of one column have alternating signs and
    nearly cancel, by a factor that grows like (1 + √2)^n, 5e7 at degree 20.
    """
    K = np.zeros((degree + 1, degree + 1), dtype=np.longdouble)
    K[0, 0] = 1.0
    if degree:
        K[:2, 1] = offset, slope
    for k in range(2, degree + 1):
        K[:, k] = 2.0 * np.longdouble(offset) * K[:, k - 1] - K[:, k - 2]
        K[1:, k] += 2.0 * np.longdouble(slope) * K[:-1, k - 1]
    return K


def powers_to_chebyshev(degree: int, slope: float, offset: float) -> ExtendedArray:
    """Return L, (n+1, n+1): u^j = Σ_k L[k, j] T_k(slope·u + offset), the inverse of `chebyshev_to_powers`.

    With t = slope·u + offset each power is the one before it times (t − offset)/slope, and t T_k = (T_{k+1} +
    T_{|k−1|})/2. Computed in extended precision where the platform has it.

    >>> powers_to_chebyshev(2, 1.0, 0.0)[:, 2].astype(float).tolist()       # u² = (T_0 + T_2)/2
    [0.5, 0.0, 0.5]
    """
    L = np.zeros((degree + 1, degree + 1), dtype=np.longdouble)
    L[0, 0] = 1.0
    for j in range(degree):
        times_t = np.zeros(degree + 2, dtype=np.longdouble)
        times_t[1:] += L[:, j] / 2.0
        times_t[:degree] += L[1:, j] / 2.0
        times_t[1] += L[0, j] / 2.0
        L[:, j + 1] = (times_t[:-1] - np.longdouble(offset) * L[:, j]) / np.longdouble(slope)
    return L
