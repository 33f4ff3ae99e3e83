"""Components of a zero set that are smaller than the cells of a grid, so that no two nodes differ in sign.

Between nodes of one sign a polynomial can reach the other sign and come back. Where it does, |f| has a local minimum,
which a fine grid still shows: the quadratic through the neighbours of the lowest node estimates where the minimum is,
and the sign of f at that place decides.
"""

from itertools import product

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.polynomial import evaluation, univariate
from ipcore.polynomial.univariate import Basis

MINIMUM_REACH = 1.5  # cells along each axis: the farthest from its lowest node that a minimum is taken to be


def subgrid_components(
    tensor: FloatArray, lines: FloatArray, f: FloatArray, excluded: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Return the local minima of |f| at which f has another sign than at all nodes around, and the values of f there.

    Parameters
    ----------
    tensor
        (n+1, …), Chebyshev coefficients of f.
    lines
        (N,), evenly spaced grid lines, the same along every axis.
    f
        (N, …), the values of f on the grid.
    excluded
        (N, …), nodes that are left out: those beside a change of sign, whose component the grid shows.

    Returns
    -------
        (M, d), in the Chebyshev variables, and (M,).

    """
    nodes = _local_minima(np.abs(f), excluded)
    t = lines[nodes] + _steps_to_minimum(f, nodes) * (lines[1] - lines[0])
    tables = [univariate.table(Basis.CHEBYSHEV, np.ascontiguousarray(x), len(tensor) - 1) for x in t.T]
    values = evaluation.scattered(tensor[None], tables)[0]
    other_sign = values * f[tuple(nodes.T)] < 0.0
    return t[other_sign], values[other_sign]


def _local_minima(size: FloatArray, excluded: BoolArray) -> IntArray:
    """Return the inner nodes (M, d), none `excluded` (N, …), where `size` (N, …) is no larger than at any neighbour.

    Neighbours are the 3^d − 1 nodes around. Minima along the first axis are found first, for the whole grid at once;
    they are so few that their other neighbours are then read one by one.
    """
    inner = (slice(1, -1),) * size.ndim
    low = np.zeros(size.shape, dtype=bool)
    low[inner] = size[inner] <= size[(slice(2, None), *inner[1:])]
    low[inner] &= size[inner] <= size[(slice(-2), *inner[1:])]
    low[inner] &= ~excluded[inner]
    nodes, row = np.flatnonzero(low), size.ravel()
    strides = np.array(size.strides) // size.itemsize
    for step in product((-1, 0, 1), repeat=size.ndim):
        nodes = nodes[row[nodes] <= row[nodes + strides @ step]]
    return np.stack(np.unravel_index(nodes, size.shape), axis=1)


def _steps_to_minimum(f: FloatArray, nodes: IntArray) -> FloatArray:
    """Return the steps from nodes (M, d) to the stationary points of the quadratics through their neighbours.

    The steps (M, d) are in cells; `f` (N, …) are the values on the grid.
    """
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
    return np.clip(step[:, :, 0], -MINIMUM_REACH, MINIMUM_REACH)
