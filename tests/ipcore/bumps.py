"""Polynomials whose zero sets no low degree reproduces."""

import numpy as np

from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis


def bumpy(dimension: int, seed: int, height: float = 0.3) -> ImplicitPolynomial:
    """Return a sphere of degree 12 with random bumps, in Chebyshev products on a cube of ±1.5."""
    rng, half = np.random.default_rng(seed), 1.5
    powers = graded.exponents(dimension, 12)
    a = height * rng.normal(size=len(powers)) / (1 + powers.sum(axis=1))
    a[0] += dimension * half**2 / 2 - 1.0
    a[graded.column(2 * np.eye(dimension, dtype=np.intp))] += half**2 / 2  # (half t)² = half²/2 (T₂(t) + 1)
    bounds = np.array([[-half] * dimension, [half] * dimension])
    return ImplicitPolynomial(12, a, Frame(np.zeros(dimension), 1.0), bounds, Basis.CHEBYSHEV)
