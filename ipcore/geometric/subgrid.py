"""Pieces of a zero set that are smaller than a grid's cells.

Between nodes of one sign a polynomial can dip to the other one and back. Where it does, |f| has a local minimum, which
a fine grid still shows: the quadratic through the neighbours of its lowest node tells where the bottom is, and f there
tells whether it is on the other side of 0.
"""

from itertools import product

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.polynomial import evaluation, univariate
from ipcore.polynomial.univariate import Basis

REACH = 1.5  # cells from its lowest node within which a bottom is looked for


def specks(tensor: FloatArray, lines: FloatArray, f: FloatArray, beside: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Return where f has the other sign than all nodes around, and its values there.

    Parameters
    ----------
    tensor
        (n+1, …), Chebyshev coefficients.
    lines
        (N,), even grid lines, the same along every axis.
    f
        (N, …), values on the grid.
    beside
        (N, …), nodes beside a change of sign: what is there is no speck.

    Returns
    -------
        (M, d) in the Chebyshev variables, and (M,).

    """
    nodes = _lowest(np.abs(f), beside)
    t = lines[nodes] + _to_bottom(f, nodes) * (lines[1] - lines[0])
    tables = [univariate.table(Basis.CHEBYSHEV, np.ascontiguousarray(x), len(tensor) - 1) for x in t.T]
    values = evaluation.scattered(tensor[None], tables)[0]
    other = values * f[tuple(nodes.T)] < 0.0
    return t[other], values[other]


def _lowest(size: FloatArray, but: BoolArray) -> IntArray:
    """Return the inner nodes (M, d), `but` some, than which none of the 3^d − 1 around is lower.

    Those that are lowest along the first axis are few enough to ask for each neighbour of the rest by number.
    """
    inner = (slice(1, -1),) * size.ndim
    low = np.zeros(size.shape, dtype=bool)
    low[inner] = size[inner] <= size[(slice(2, None), *inner[1:])]
    low[inner] &= size[inner] <= size[(slice(-2), *inner[1:])]
    low[inner] &= ~but[inner]
    nodes, row = np.flatnonzero(low), size.ravel()
    strides = np.array(size.strides) // size.itemsize
    for step in product((-1, 0, 1), repeat=size.ndim):
        nodes = nodes[row[nodes] <= row[nodes + strides @ step]]
    return np.stack(np.unravel_index(nodes, size.shape), axis=1)


def _to_bottom(f: FloatArray, nodes: IntArray) -> FloatArray:
    """Return the steps (M, d), in cells, from nodes to where the quadratic through their neighbours is stationary."""
    d = f.ndim
    unit = np.eye(d, dtype=np.intp)
    gradient, hessian = np.empty((len(nodes), d)), np.empty((len(nodes), d, d))

    def at(offset: IntArray) -> FloatArray:
        return np.asarray(f[tuple((nodes + offset).T)])

    for i in range(d):
        ahead, behind = at(unit[i]), at(-unit[i])
        gradient[:, i] = (ahead - behind) / 2.0
        hessian[:, i, i] = ahead - 2.0 * at(0 * unit[i]) + behind
        for j in range(i):
            corners = at(unit[i] + unit[j]) - at(unit[i] - unit[j]) - at(unit[j] - unit[i]) + at(-unit[i] - unit[j])
            hessian[:, i, j] = hessian[:, j, i] = corners / 4.0
    step = -np.linalg.pinv(hessian, hermitian=True) @ gradient[:, :, None]
    return np.clip(step[:, :, 0], -REACH, REACH)
