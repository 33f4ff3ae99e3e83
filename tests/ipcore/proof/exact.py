"""Polynomials in rational arithmetic."""

from fractions import Fraction
from itertools import product

import numpy as np

from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.proof.blocks import Blocks


def polynomial(
    dimension: int, degree: int, seed: int, basis: Basis = Basis.MONOMIAL, half: float = 1.4
) -> ImplicitPolynomial:
    """Return a polynomial with normally distributed coefficients on a box that is not symmetric."""
    a = np.random.default_rng(seed).normal(size=graded.count(dimension, degree))
    bounds = np.array([[-half] * dimension, [0.9 * half] * dimension])
    return ImplicitPolynomial(degree, a, Frame(np.zeros(dimension), 1.0), bounds, basis)


def univariate(basis: Basis, degree: int, u: Fraction) -> tuple[list[Fraction], list[Fraction]]:
    """Return the functions of degree 0…n at u, and their derivatives."""
    values, slopes = [Fraction(1), u], [Fraction(0), Fraction(1)]
    while len(values) <= degree:
        twice = 2 if basis is Basis.CHEBYSHEV else 1
        before = values[-2] if basis is Basis.CHEBYSHEV else 0
        slope_before = slopes[-2] if basis is Basis.CHEBYSHEV else 0
        slopes.append(twice * (values[-1] + u * slopes[-1]) - slope_before)
        values.append(twice * u * values[-1] - before)
    return values[: degree + 1], slopes[: degree + 1]


def value(tensor: FloatArray, functions: list[list[Fraction]]) -> Fraction:
    """Return Σ a_ijk X_i Y_j Z_k."""
    total = Fraction(0)
    for at in product(*(range(size) for size in tensor.shape)):
        term = Fraction(float(tensor[at]))
        for axis, k in enumerate(at):
            term *= functions[axis][k]
        total += term
    return total


def variable(p: ImplicitPolynomial, blocks: Blocks, block: int, axis: int, s: Fraction) -> tuple[Fraction, Fraction]:
    """Return the variable at s, −1 … 1, of a block, and its derivative with respect to s."""
    step = blocks.size[axis] * 2**blocks.halvings
    edges = p.variable(blocks.lower[axis] + np.arange(blocks.parts + 1) * step, axis)
    first, part = divmod(int(blocks.place[block, axis]), 2**blocks.halvings)
    start, end = Fraction(float(edges[first])), Fraction(float(edges[first + 1]))
    length = (end - start) / 2**blocks.halvings
    return start + length * (part + (s + 1) / 2), length / 2


def errors(p: ImplicitPolynomial, blocks: Blocks, block: int, s: list[Fraction]) -> tuple[Fraction, list[Fraction]]:
    """Return by how much f, and each of its derivatives with respect to x_k, differs from that of the coefficients."""
    d = p.dimension
    places = [variable(p, blocks, block, axis, one) for axis, one in enumerate(s)]
    there = [univariate(p.basis, p.degree, u) for u, _ in places]
    here = [univariate(Basis.CHEBYSHEV, blocks.degree, one) for one in s]
    c = blocks.coefficients[..., block]

    def difference(derived: int | None) -> Fraction:
        true = value(p.tensor, [there[k][k == derived] for k in range(d)])
        seen = value(c, [here[k][k == derived] for k in range(d)])
        return true * (1 if derived is None else places[derived][1]) - seen

    sizes = [Fraction(float(size)) / 2 for size in blocks.size]
    return difference(None), [difference(k) / sizes[k] for k in range(d)]
