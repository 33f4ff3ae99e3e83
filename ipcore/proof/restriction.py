"""A polynomial restricted to blocks of its box: its coefficients there, from those that are delivered."""

from dataclasses import replace

import numpy as np

from ipcore._typing import FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.proof.blocks import Blocks
from ipcore.proof.intervals import local
from ipcore.proof.rounding import EPSILON, roundings

# By how much the box of the blocks is larger than the bounds, as a share: places on the walls have rounded variables.
BOX_GROWTH = 2.0**-30


def first_blocks(polynomial: ImplicitPolynomial, parts: int) -> Blocks:
    """Return the blocks that divide a polynomial's bounds into `parts` along each axis."""
    d = polynomial.dimension
    grown = polynomial.bounds + BOX_GROWTH * np.diff(polynomial.bounds, axis=0) * np.array([[-1.0], [1.0]])
    place = np.indices((parts,) * d).reshape(d, -1).T.astype(float)
    empty = np.zeros((*(0,) * d, len(place)))
    none, size = np.zeros((len(place), d)), (grown[1] - grown[0]) / parts
    return restricted(polynomial, Blocks(empty, place, 0, none[:, 0], none, grown[0], size, parts))


def restricted(polynomial: ImplicitPolynomial, blocks: Blocks) -> Blocks:
    """Return blocks with all coefficients of a polynomial on them, and the slack of the rounding in these only.

    With the absolute values Σ |a_ijk| X_i Y_j Z_k, where X_i = Σ_p |X_pi| bounds a function and its coefficients, the
    sums along d axes are off by d (n + 2) ε of it. The functions' own coefficients and values of f are rounded as well.
    """
    n, d = polynomial.degree, polynomial.dimension
    tables = [_along(polynomial, blocks, axis) for axis in range(d)]
    largest = [np.abs(X).sum(axis=1) for X, _ in tables]
    if polynomial.basis is Basis.CHEBYSHEV:
        largest = [np.maximum(sums, 1.0) for sums in largest]
    size = np.abs(polynomial.tensor)
    slack = (d * (n + 2) + roundings(polynomial)) * EPSILON * _products(size, largest)
    for axis, (_, off) in enumerate(tables):
        slack += _products(size, [off if k == axis else sums for k, sums in enumerate(largest)])
    coefficients = _contracted(polynomial.tensor, [X for X, _ in tables])
    slack *= 1.01  # for the products of two such errors
    # errors are those of coefficients of T_i, and |T_i'| ≤ i²
    return replace(
        blocks,
        coefficients=coefficients,
        slack=slack,
        slope_slack=slack[:, None] * (n**2 * 2.0 / blocks.size),
    )


def _along(polynomial: ImplicitPolynomial, blocks: Blocks, axis: int) -> tuple[FloatArray, FloatArray]:
    """Return the univariate functions on the blocks along an axis, (B, n+1, n+1), and how much they may be off.

    The variable is rounded at the edges of the first blocks only; on their parts it is taken as these divide it. Of
    Chebyshev polynomials t = (x − m)/h it is, with the middle m and half the length h of the bounds as doubles.
    """
    edges = blocks.lower[axis] + np.arange(blocks.parts + 1) * (blocks.size[axis] * 2**blocks.halvings)
    variable = polynomial.variable(edges, axis).astype(np.longdouble)
    place, which = np.unique(blocks.place[:, axis], return_inverse=True)
    first, part = np.divmod(place, 2**blocks.halvings)
    start, length = variable[first.astype(np.intp)], np.diff(variable)[first.astype(np.intp)]
    low, high = (start + length * ((part + end) / 2**blocks.halvings) for end in (0.0, 1.0))
    reach = float(np.abs(variable).max() + np.abs(length).max())
    X, off = local(polynomial.basis, polynomial.degree, low, high, reach)
    return X[which], off[which]


def _contracted(tensor: FloatArray, tables: list[FloatArray]) -> FloatArray:
    """Return Σ a_ijk X_pi Y_qj Z_rk for the tables X, Y[, Z] (B, n+1, n+1) of each block, (n+1, …, B)."""
    count, rows = len(tables[0]), len(tensor)
    out = np.broadcast_to(tensor, (count, *tensor.shape))
    for table in tables:  # the contracted axis goes last, so after d steps the axes stand in order again
        out = np.swapaxes(table @ out.reshape(count, rows, rows ** (tensor.ndim - 1)), 1, 2).reshape(
            count, *tensor.shape
        )
    return np.ascontiguousarray(np.moveaxis(out, 0, -1))


def _products(size: FloatArray, vectors: list[FloatArray]) -> FloatArray:
    """Return Σ |a_ijk| x_i y_j z_k for the vectors (B, n+1) of each block, (B,)."""
    out = np.tensordot(vectors[0], size, axes=1)
    for vector in vectors[1:]:
        out = np.einsum("bi...,bi->b...", out, vector)
    return np.asarray(out)
