"""How much values of f may be off, as they are computed in doubles, term by term."""

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.polynomial import evaluation, graded
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis

BEYOND_BOUNDS = 1.001  # by what factor powers may be larger than at the bounds, which the blocks exceed a little
EPSILON = float(np.finfo(float).eps)


def roundings(polynomial: ImplicitPolynomial) -> int:
    """Return how many ε of Σ |a_ijk X_i Y_j Z_k| a computed value may be off.

    Here X_i, Y_j and Z_k are bounds of the univariate functions, at least 1 for Chebyshev polynomials. The m − 1 sums
    and the products of each term give m + 4. The powers of degree ≤ n give 3 n, with the rounding of the variable; the
    Chebyshev polynomials 4 n²: their slope is n² at the ends, and in T_{m+j} = 2 T_m T_j − T_{m−j} errors add up to
    less than 2 n².
    """
    n = polynomial.degree
    functions = 3 * n if polynomial.basis is Basis.MONOMIAL else 4 * n**2
    return graded.count(polynomial.dimension, n) + functions + 4


def lost_in_rounding(polynomial: ImplicitPolynomial, x: FloatArray, f: FloatArray) -> BoolArray:
    """Return which of the values f (K,), as they are computed at places x (K, d) in the bounds, may have a wrong sign.

    One bound for all places decides about most of them; it is far larger than the bounds at each place.

    >>> from ipcore import shapes
    >>> sphere, x = shapes.sphere().polynomial, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.5]])
    >>> lost_in_rounding(sphere, x, sphere(x)).tolist()
    [True, False]
    """
    size = roundings(polynomial) * EPSILON * np.abs(polynomial.tensor)
    if polynomial.basis is Basis.CHEBYSHEV:
        return np.asarray(~(np.abs(f) > size.sum()))
    ends = [
        BEYOND_BOUNDS * np.abs(table).max(axis=0, keepdims=True) for table in polynomial.tables([*polynomial.bounds.T])
    ]
    doubtful = ~(np.abs(f) > evaluation.along_axes(size, ends).item())
    some = [np.ascontiguousarray(column) for column in x[doubtful].T]
    tables = [np.abs(table.T) for table in polynomial.tables(some)]
    doubtful[doubtful] = ~(np.abs(f[doubtful]) > evaluation.scattered(size[None], tables)[0])
    return np.asarray(doubtful)
