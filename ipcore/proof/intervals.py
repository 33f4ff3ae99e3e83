"""The univariate functions on intervals of their variable, in Chebyshev polynomials of each interval.

On an interval with the middle m and half the length h the variable is u = m + h s, −1 ≤ s ≤ 1. The function of degree k
is Σ_i X_ik T_i(s) there.
"""

from fractions import Fraction
from functools import lru_cache
from math import comb
from operator import mul

import numpy as np

from ipcore._typing import ExtendedArray, FloatArray
from ipcore.polynomial.univariate import Basis

# Chebyshev polynomials stay within ±1 on −1 … 1, and grow no faster than their degree this little beyond it.
BEYOND = 1e-6


def local(
    basis: Basis, degree: int, low: FloatArray | ExtendedArray, high: FloatArray | ExtendedArray, reach: float
) -> tuple[FloatArray, FloatArray]:
    """Return X and by how much its columns may be off.

    Each function is u times the one before it, for Chebyshev polynomials twice that less the one before, and
    s T_i = (T_{i+1} + T_{|i−1|})/2. This is computed in extended precision where the platform has it.

    Parameters
    ----------
    basis
        The univariate functions.
    degree
        n.
    low, high
        (B,), the ends of the intervals.
    reach
        A bound of the numbers from which the ends were computed: they are off by 4 ε `reach` at most, with the ε of
        extended precision.

    Returns
    -------
        X (B, n+1, n+1), the second axis for i, and (B, n+1), a bound of Σ_i |error of X_ik|.

    >>> X, off = local(Basis.MONOMIAL, 2, np.array([0.0]), np.array([2.0]), 2.0)    # u = 1 + s, u² = 3/2 + 2s + T_2/2
    >>> X[0].T.tolist(), bool(off.max() < 1e-14)
    ([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.5, 2.0, 0.5]], True)
    """
    low, high = low.astype(np.longdouble), high.astype(np.longdouble)
    middle, half = (low + high) / 2, (high - low) / 2
    X = np.zeros((degree + 1, degree + 1, len(low)), dtype=np.longdouble)  # k, i, interval
    X[0, 0] = 1.0
    for k in range(1, degree + 1):
        a, twice = X[k - 1], 2.0 if basis is Basis.CHEBYSHEV and k > 1 else 1.0
        X[k] = twice * middle * a
        X[k, 1:] += twice / 2.0 * half * a[:-1]
        X[k, :-1] += twice / 2.0 * half * a[1:]
        X[k, 1] += twice / 2.0 * half * a[0]
        if twice > 1.0:
            X[k] -= X[k - 2]
    sums = np.abs(X).sum(axis=1).astype(float)
    off = _roundings(basis, sums, (np.abs(middle) + half).astype(float), reach) * float(np.finfo(np.longdouble).eps)
    off += float(np.finfo(float).eps) * sums
    return np.ascontiguousarray(X.transpose(2, 1, 0).astype(float)), np.ascontiguousarray(off.T)


def _roundings(basis: Basis, sums: FloatArray, largest: FloatArray, reach: float) -> FloatArray:
    """Return a bound of Σ_i |error of X_ik| in units of ε of extended precision, (n+1, B).

    Each step has six roundings of sums and products, and a variable that is off by 8 ε `reach` at most. With |u| ≤
    `largest` (B,), powers carry errors on as they grow themselves. An error in T_j is multiplied by U_{k−j} in
    T_k: by n + 1 − j at most on −1 … 1, and so are its coefficients, n + 1 of them; or, farther out, as the absolute
    values of all terms are, which grow as P_k = 2 `largest` P_{k−1} + P_{k−2}.
    """
    n = len(sums) - 1
    k, reach = np.arange(n + 1)[:, None], max(reach, 1.0)
    if basis is Basis.MONOMIAL:
        return np.asarray(8.0 * k * (largest**k + reach * largest ** np.maximum(k - 1, 0)))
    P = np.ones((n + 1, len(largest)))
    for j in range(1, n + 1):
        P[j] = (2.0 * largest * P[j - 1] + P[j - 2]) if j > 1 else largest
    inside = 32.0 * (n + 1) ** 3 * reach * sums.max(axis=0)
    return np.where(largest <= 1.0 + BEYOND, inside, 16.0 * k * (k + 1) * reach * P)


@lru_cache(maxsize=64)
def halving(degree: int) -> tuple[FloatArray, FloatArray]:
    """Return the matrices (n+1, n+1) that map Chebyshev coefficients to those on the lower and on the upper half.

    >>> [half.tolist() for half in halving(1)]
    [[[1.0, -0.5], [0.0, 0.5]], [[1.0, 0.5], [0.0, 0.5]]]
    """
    ends = np.array([-1.0, 0.0, 1.0], dtype=np.longdouble)
    lower, upper = local(Basis.CHEBYSHEV, degree, ends[:-1], ends[1:], 1.0)[0]
    return lower, upper


@lru_cache(maxsize=64)
def to_bernstein(degree: int) -> FloatArray:
    """Return the matrix (n+1, n+1) that maps Chebyshev coefficients on −1 … 1 to Bernstein coefficients there.

    T_k has Σ_i C(j, i)/C(n, i) p_i, with its powers Σ p_i u^i in u = (s + 1)/2. These nearly cancel, so they are summed
    in rational numbers: each entry is rounded once.

    >>> to_bernstein(2).tolist()                                                 # T_2 = 1, −3, 1
    [[1.0, -1.0, 1.0], [1.0, 0.0, -3.0], [1.0, 1.0, 1.0]]
    """
    powers = [[1], [-1, 2]]
    while len(powers) <= degree:  # T_{k+1} = 2 (2u − 1) T_k − T_{k−1}
        last, before = powers[-1], [*powers[-2], 0, 0]
        powers.append([4 * low - 2 * high - old for low, high, old in zip([0, *last], [*last, 0], before, strict=True)])
    share = [[Fraction(comb(j, i), comb(degree, i)) for i in range(degree + 1)] for j in range(degree + 1)]
    rows = [[sum(map(mul, one, p)) for p in powers[: degree + 1]] for one in share]
    return np.array([[float(entry) for entry in row] for row in rows])
