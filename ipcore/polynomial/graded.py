r"""Graded order of the monomials in one, two or three variables.

The column index α (from 1) of x^i y^j z^k, with s the total degree, is (Zheng, Takamatsu, Ikeuchi, ACCV 2007, Table 1)

    2D: α = j + s(s + 1)/2 + 1                                     1; x, y; x², xy, y²; …
    3D: α = s(s + 1)(s + 2)/6 + k(s + 1) − k(k − 1)/2 + j + 1      1; x, y, z; x², xy, y², xz, yz, z²; …

The 3D formula is the one that gives the order which Table 1 prints; the paper's own formula gives x², xy, xz, y², …
All monomials of one total degree s make the form L_s. A polynomial of degree n is a prefix of every higher one.
"""

from functools import lru_cache

import numpy as np

from ipcore._typing import FloatArray, IntArray


def count(dimension: int, degree: int) -> int:
    """Return the number of monomials of total degree ≤ `degree`: (n+1)(n+2)/2 in 2D, (n+1)(n+2)(n+3)/6 in 3D.

    >>> count(2, 4), count(3, 4)
    (15, 35)
    """
    product = 1
    for k in range(1, dimension + 1):
        product = product * (degree + k) // k
    return product


def highest_determined(dimension: int, points: int, most: int) -> int:
    """Return the highest degree, from 1 to `most`, whose polynomials so many points determine, up to a factor.

    A polynomial with m coefficients and its multiples have the same zero set, so m − 1 points in general position
    determine it: five points a conic, nine a quadric.

    >>> highest_determined(2, 5, 10), highest_determined(3, 9, 10), highest_determined(2, 2, 10)
    (2, 2, 1)
    """
    return max((n for n in range(1, most + 1) if count(dimension, n) - 1 <= points), default=1)


def form(dimension: int, degree: int) -> slice:
    """Return the columns (from 0) of the form L_s, s = `degree`.

    >>> form(3, 2)
    slice(4, 10, None)
    """
    return slice(count(dimension, degree - 1) if degree else 0, count(dimension, degree))


@lru_cache(maxsize=64)
def exponents(dimension: int, degree: int) -> IntArray:
    """Return the exponents in graded order, shape (m, d), read-only.

    >>> exponents(2, 2).tolist()
    [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]
    """
    rows = [row for s in range(degree + 1) for row in _compositions(dimension, s)]
    table = np.array(rows, dtype=np.intp).reshape(-1, dimension)
    table.setflags(write=False)
    return table


def _compositions(dimension: int, total: int) -> list[tuple[int, ...]]:
    """Return the exponents of one form, of total degree `total`, in graded order: the last one varies slowest."""
    if dimension == 1:
        return [(total,)]
    return [(*head, last) for last in range(total + 1) for head in _compositions(dimension - 1, total - last)]


def column(powers: IntArray) -> IntArray:
    """Return the columns (…) of exponents (…, d), counted from 0, so α − 1, by the closed formulas above.

    >>> int(column(np.array([1, 0, 1])))
    7
    """
    s: IntArray = powers.sum(axis=-1)
    if powers.shape[-1] == 1:
        return s
    j: IntArray = powers[..., 1]
    if powers.shape[-1] == 2:
        return s * (s + 1) // 2 + j
    k: IntArray = powers[..., 2]
    alpha: IntArray = s * (s + 1) * (s + 2) // 6 + k * (s + 1) - k * (k - 1) // 2 + j
    return alpha


def products(tables: list[FloatArray], powers: IntArray) -> FloatArray:
    """Return the product functions X_i(x) Y_j(y) Z_k(z), one row per row (i, j, k) of `powers`.

    Parameters
    ----------
    tables
        For each variable the univariate functions of degree 0…n at N points, (n+1, N).
    powers
        The exponents of the products, (m, d).

    Returns
    -------
        (m, N)

    """
    rows = tables[0][powers[:, 0]]
    for axis in range(1, len(tables)):
        rows *= tables[axis][powers[:, axis]]
    return rows


def form_products(tables: list[FloatArray], first: int, last: int, out: FloatArray | None = None) -> FloatArray:
    """Return the products of the forms of degree `first` … `last` in graded order, (columns, N).

    It does what `products` does for one or two variables, with tables (≥ last + 1, N), but in one pass for each form
    and without copies of tables. The result is written into `out` (≥ columns, ≥ N) if given: to allocate memory for it
    takes as long as the products.

    >>> x, y = np.array([[1.0], [2.0], [4.0]]), np.array([[1.0], [3.0], [9.0]])          # x; y; x², xy, y²
    >>> form_products([x, y], 1, 2)[:, 0].tolist()
    [2.0, 3.0, 4.0, 6.0, 9.0]
    """
    if len(tables) == 1:
        return tables[0][first : last + 1]
    X, Y = tables
    start = form(2, first).start
    m, N = count(2, last) - start, X.shape[1]
    out = np.empty((m, N)) if out is None else out[:m, :N]
    for s in range(first, last + 1):
        columns = form(2, s)
        np.multiply(X[s::-1], Y[: s + 1], out=out[columns.start - start : columns.stop - start])
    return out


def sum_of_all(x: FloatArray, degree: int) -> FloatArray:
    """Return the sum of all monomials of total degree ≤ `degree` at x (N, d), shape (N,).

    By the recurrence of the complete homogeneous symmetric polynomials, h_s(x₁…x_k) = h_s(x₁…x_{k−1}) + x_k
    h_{s−1}(x₁…x_k): no monomial is formed, and where x ≥ 0 nothing cancels.

    >>> sum_of_all(np.array([[2.0, 3.0]]), 2).tolist()      # 1 + (2 + 3) + (4 + 6 + 9)
    [25.0]
    """
    h = np.zeros((degree + 1, len(x)))
    h[0] = 1.0
    for variable in x.T:
        for s in range(1, degree + 1):
            h[s] += variable * h[s - 1]
    return np.asarray(h.sum(axis=0))


def degree_of(dimension: int, columns: int) -> int:
    """Return the total degree of the last one of so many columns, the column α = `columns`.

    >>> [degree_of(2, alpha) for alpha in (1, 2, 28, 54, 92)]
    [0, 1, 6, 9, 13]
    """
    degree = 0
    while count(dimension, degree) < columns:
        degree += 1
    return degree
