"""Circles, and products of polynomials of degree 2, in Chebyshev products on one box."""

import numpy as np

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.geometric.inside_outside import InsideOutside

BOUNDS = np.array([[-1.3, -1.3], [1.3, 1.3]])


def unit_circle() -> InsideOutside:
    """Return the inside and outside of 400 points on the unit circle."""
    points, normals = shapes.circle().sample(400)
    return InsideOutside(points, normals, BOUNDS)


def tensor_of(coefficients: dict[tuple[int, int], float]) -> FloatArray:
    """Return Chebyshev coefficients (5, 5) on the bounds of Σ c x^i y^j, i and j at most 2 and one of them 0."""
    h, out = 1.3, np.zeros((5, 5))
    for (i, j), c in coefficients.items():
        for k, power in ((i, (1, 0)), (j, (0, 1))):
            if k == 2:  # x² = h² (1 + T_2(t)) / 2
                out[0, 0] += c * h**2 / 2.0
                out[2 * power[0], 2 * power[1]] += c * h**2 / 2.0
        if i == j == 0:
            out[0, 0] += c
        if i + j == 1:
            out[i, j] += c * h
    return out


CIRCLE = tensor_of({(0, 0): -1.0, (2, 0): 1.0, (0, 2): 1.0})


def multiplied(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the product of two polynomials of degree 2 or less in Chebyshev products, by values at 9 nodes."""
    nodes = np.cos(np.pi * (np.arange(9) + 0.5) / 9)
    values = np.polynomial.chebyshev.chebgrid2d(nodes, nodes, a) * np.polynomial.chebyshev.chebgrid2d(nodes, nodes, b)
    V = np.polynomial.chebyshev.chebvander(nodes, 8)
    inverse = np.linalg.inv(V)
    return np.asarray(inverse @ values @ inverse.T)[:5, :5]
