"""Weighted Gram matrices of Chebyshev products, from moments.

T_i T_j = (T_{i+j} + T_{|i−j|}) / 2. So with P the row of all products T_i(x) T_j(y) T_k(z) of total degree ≤ n, every
entry of Σ w PᵀP is a mean of 2^d moments μ_ijk = Σ w T_i(x) T_j(y) T_k(z), i + j + k ≤ 2n. There are only C(2n + d, d)
moments, and a few matrix products give them for many weights at once.
"""

from functools import lru_cache

import numpy as np
from scipy.sparse import coo_array, csr_array

from ipcore._typing import FloatArray, IntArray
from ipcore.polynomial import evaluation, graded, univariate
from ipcore.polynomial.univariate import Basis

Sparse = csr_array[np.float64, tuple[int, int]]

# A pass takes many points, for during each call from Python other threads must wait. The last variable's functions,
# weighted, then take 4 MB at most, and the products of the others are formed some forms at a time.
PASS_POINTS = 8192  # at most
PASS_ENTRIES = 1 << 19  # of the last variable's weighted functions, at most
BAND_PRODUCTS = 64  # formed together, about


@lru_cache(maxsize=32)
def order(dimension: int, degree: int) -> IntArray:
    """Return the exponents (C, d) of the moments of total degree ≤ `degree`, in the order of `moments`, read-only.

    The last variable's exponent k varies slowest; for each k stand the graded exponents of the others up to degree − k.
    """
    blocks = [
        np.pad(graded.exponents(dimension - 1, degree - k), ((0, 0), (0, 1)), constant_values=k)
        for k in range(degree + 1)
    ]
    table = np.concatenate(blocks)
    table.setflags(write=False)
    return table


def position(powers: IntArray, degree: int) -> IntArray:
    """Return the positions (…) in `order` of the moments with exponents (…, d); `degree` is that of `order`."""
    d = powers.shape[-1]
    starts = np.cumsum([0] + [graded.count(d - 1, degree - k) for k in range(degree)])
    return np.asarray(starts[powers[..., -1]] + graded.column(powers[..., :-1]))


def moments(tables: list[FloatArray], weights: FloatArray) -> FloatArray:
    """Return the moments μ = Σ w T_i(x) T_j(y) T_k(z) over N points, for p weights of each point.

    Parameters
    ----------
    tables
        For each variable the Chebyshev polynomials of degree 0…K at the points, (K + 1, N).
    weights
        (p, N).

    Returns
    -------
        (C, p), in the order of `order`(d, K).

    Examples
    --------
    >>> t = np.array([0.5, 1.0])                                  # T_2(½) = −½, T_2(1) = 1
    >>> table = univariate.table(Basis.CHEBYSHEV, t, 2)
    >>> mu = moments([table, table], np.array([[1.0, 2.0]]))
    >>> float(mu[position(np.array([2, 0]), 2), 0])                # 1 · −½ + 2 · 1
    1.5

    """
    d, degree, p = len(tables), len(tables[0]) - 1, len(weights)
    bands = _bands(d - 1, degree)
    sums = np.zeros((graded.count(d - 1, degree), (degree + 1) * p))
    size = max(1, min(PASS_POINTS, PASS_ENTRIES // ((degree + 1) * p), weights.shape[1]))
    scratch = np.empty((max(band.stop - band.start for _, _, band in bands), size))
    for start in range(0, weights.shape[1], size):
        part = slice(start, start + size)
        *others, last = (table[:, part] for table in tables)
        weighted = (last[:, None] * weights[:, part]).reshape(-1, last.shape[1])
        for low, high, band in bands:
            columns = (degree - low + 1) * p
            sums[band, :columns] += graded.form_products(others, low, high, scratch) @ weighted[:columns].T
    powers = order(d, degree)
    return np.asarray(sums.reshape(len(sums), degree + 1, p)[graded.column(powers[:, :-1]), powers[:, -1]])


@lru_cache(maxsize=32)
def _bands(dimension: int, degree: int) -> list[tuple[int, int, slice]]:
    """Return the forms 0 … `degree` in bands of about `BAND_PRODUCTS` columns: first and last degree, and columns."""
    out, first = [], 0
    for last in range(degree + 1):
        columns = slice(graded.form(dimension, first).start, graded.form(dimension, last).stop)
        if last == degree or graded.form(dimension, last + 1).stop - columns.start > BAND_PRODUCTS:
            out.append((first, last, columns))
            first = last + 1
    return out


def in_graded_order(mu: FloatArray, dimension: int, degree: int) -> FloatArray:
    """Return moments (C, p) of total degree ≤ `degree` in the graded order of the coefficients, (m, p)."""
    return mu[position(graded.exponents(dimension, degree), degree)]


def grid_moments(weights: FloatArray, table: FloatArray) -> FloatArray:
    """Return the moments (C, 1) over the nodes of a tensor grid, the same along every axis.

    `weights` (nodes, …) are those of the nodes; `table` (K + 1, nodes) are the Chebyshev polynomials at the grid lines.
    """
    tensor = evaluation.along_axes(weights, [table] * weights.ndim)
    return np.asarray(tensor[tuple(order(weights.ndim, len(table) - 1).T)][:, None])


@lru_cache(maxsize=16)
def _pairs(dimension: int, degree: int) -> tuple[Sparse, IntArray, IntArray]:
    """Return the matrix (T, C) from moments to the T entries of the Gram matrix's upper triangle, and their places.

    The places are the rows (T,) and the columns (T,) of the entries.
    """
    E = graded.exponents(dimension, degree)
    rows, columns = np.triu_indices(len(E))
    total, difference = E[rows] + E[columns], np.abs(E[rows] - E[columns])
    where = []
    for bits in range(2**dimension):
        plus = np.array([bits >> k & 1 for k in range(dimension)], dtype=bool)
        where.append(position(np.where(plus, total, difference), 2 * degree))
    index = np.stack(where, axis=1)
    count, each = index.shape
    shape = (count, graded.count(dimension, 2 * degree))
    data, starts = np.full(index.size, 1.0 / each), np.arange(0, index.size + 1, each)
    return csr_array((data, index.ravel(), starts), shape=shape), rows, columns


def gram(mu: FloatArray, dimension: int, degree: int) -> FloatArray:
    """Return the symmetric Gram matrices (p, m, m) from moments (C, p) up to 2·`degree`.

    >>> t = np.array([0.5, 1.0])
    >>> tables = [univariate.table(Basis.CHEBYSHEV, t, 2)] * 2
    >>> gram(moments(tables, np.ones((1, 2))), 2, 1)[0].tolist()   # rows 1, x, y at (½, ½) and (1, 1)
    [[2.0, 1.5, 1.5], [1.5, 1.25, 1.25], [1.5, 1.25, 1.25]]
    """
    gather, rows, columns = _pairs(dimension, degree)
    m = graded.count(dimension, degree)
    entries = np.asarray(gather @ mu)
    out = np.empty((mu.shape[1], m, m))
    out[:, rows, columns] = entries.T
    out[:, columns, rows] = entries.T
    return out


@lru_cache(maxsize=64)
def differentiation(dimension: int, degree: int, axis: int) -> Sparse:
    """Return D (m, m): if a (m,) are the coefficients of f in Chebyshev products, D a are those of ∂f/∂t_axis."""
    E, single = graded.exponents(dimension, degree), univariate.differentiation(Basis.CHEBYSHEV, degree)
    rows, columns, entries = [], [], []
    for low, high in zip(*np.nonzero(single), strict=True):
        source = np.flatnonzero(E[:, axis] == high)
        target = E[source].copy()
        target[:, axis] = low
        rows.append(graded.column(target))
        columns.append(source)
        entries.append(np.full(len(source), single[low, high]))
    m = len(E)
    if not rows:
        return csr_array((m, m))
    where = (np.concatenate(rows), np.concatenate(columns))
    return coo_array((np.concatenate(entries), where), shape=(m, m)).tocsr()
