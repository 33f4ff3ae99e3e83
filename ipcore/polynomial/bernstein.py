"""Bounds of a polynomial's values on the blocks of a box, by its Bernstein coefficients there.

On the unit interval u^i = Σ_{j ≥ i} C(j, i)/C(n, i) B_j(u), with the Bernstein polynomials
B_j(u) = C(n, j) u^j (1−u)^(n−j), which are positive and add up to 1. So a polynomial's values on a block lie between
its least and its greatest coefficient in products of B_j there (Farouki and Rajan 1987). The smaller the block, the
tighter are the bounds: at degree 12, with blocks of a sixteenth of the box along each axis, there are few blocks whose
bounds have different signs but that contain no zero.
"""

from math import comb

import numpy as np

from ipcore._typing import ExtendedArray, FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis


def matrices(basis: Basis, degree: int, ends: FloatArray) -> FloatArray:
    """Return the matrices (B, n+1, n+1) that map univariate coefficients to Bernstein coefficients on B intervals.

    `ends` (2, B) are the lower and the upper ends of the intervals, in the variable of the univariate functions.

    >>> matrices(Basis.MONOMIAL, 2, np.array([[0.0], [2.0]]))[0] @ [0.0, 0.0, 1.0]       # t² = 4u² on 0 … 2
    array([0., 0., 4.])
    """
    n = degree
    W = np.array([[comb(j, i) / np.longdouble(comb(n, i)) for i in range(n + 1)] for j in range(n + 1)])
    a, b = ends.astype(np.longdouble)  # in which their difference is exact, mostly
    return np.stack([W @ _powers(basis, n, low, length) for low, length in zip(a, b - a, strict=True)]).astype(float)


def ranges(polynomial: ImplicitPolynomial, ends: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return lower and upper bounds of f on the blocks of a box: the least and the greatest Bernstein coefficient.

    They are widened by a bound of the rounding, so that they also bound values of f that are computed in doubles.

    Parameters
    ----------
    polynomial
        f.
    ends
        For each axis the lower and upper ends of the blocks, raw, (2, B_axis).

    Returns
    -------
        Lower and upper bounds, (B_x, B_y[, B_z]) each.

    """
    n = polynomial.degree
    tables = [matrices(polynomial.basis, n, polynomial.variable(x, axis)) for axis, x in enumerate(ends)]
    first, *others = tables
    shape = [n + 1, *(part for table in others for part in table.shape[:2])]
    low, high = np.empty((2, *(x.shape[1] for x in ends)))
    for k, slab in enumerate(
        first
    ):  # block after block along the first axis, or the coefficients would take as much memory as a grid
        b = np.tensordot(slab, polynomial.tensor, axes=1)
        for table in others:  # the contracted axis goes last, so the next one comes second
            b = np.tensordot(b, table.reshape(-1, n + 1), axes=(1, 1))
        b = b.reshape(shape)
        coefficients = tuple(range(0, b.ndim, 2))
        low[k], high[k] = b.min(axis=coefficients), b.max(axis=coefficients)
    slack = _rounding(polynomial.tensor, tables)
    return low - slack, high + slack


def _rounding(tensor: FloatArray, tables: list[FloatArray]) -> float:
    """Return a bound of the rounding in sums along each axis: 2 (n+1) d ε Σ |a_ijk| max |X_i| max |Y_j| max |Z_k|.

    `tensor` (n+1, …) are the coefficients, `tables` (B, n+1, n+1) the matrices X, Y[, Z] of the blocks along each axis.
    Each of the d sums has n+1 terms; half of the bound is for the Bernstein coefficients, half for values of f.
    """
    total = np.abs(tensor)
    for table in tables:
        total = np.tensordot(total, np.abs(table).max(axis=(0, 1)), axes=(0, 0))
    return 2.0 * len(tensor) * tensor.ndim * float(np.finfo(float).eps) * float(total)


def _powers(basis: Basis, degree: int, start: np.longdouble, length: np.longdouble) -> ExtendedArray:
    """Return K, (n+1, n+1): the univariate function of degree k at start + length·u is Σ_j K[j, k] u^j."""
    K = np.zeros((degree + 1, degree + 1), dtype=np.longdouble)
    K[0, 0] = 1.0
    for k in range(1, degree + 1):
        twice = 2.0 if basis is Basis.CHEBYSHEV and k > 1 else 1.0
        K[:, k] = twice * start * K[:, k - 1]
        K[1:, k] += twice * length * K[:-1, k - 1]
        if twice > 1.0:
            K[:, k] -= K[:, k - 2]
    return K
