"""Polynomials made to deceive a proof: a known shape times something tiny."""

from collections.abc import Iterator

import numpy as np
import scipy.signal

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.polynomial import evaluation
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.proof.tube import Tube


def times(shape: ImplicitPolynomial, factor: FloatArray) -> ImplicitPolynomial:
    """Return the product of a polynomial in monomials with another, given by its tensor (k+1, …)."""
    n, d = shape.degree + len(factor) - 1, shape.dimension
    tensor = scipy.signal.convolve(shape.tensor, factor, method="direct")
    return ImplicitPolynomial(n, evaluation.from_tensor(tensor, d, n), Frame(np.zeros(d), 1.0), shape.bounds)


def ball(centre: FloatArray, radius: float) -> FloatArray:
    """Return the tensor of |x − c|² − r²: a circle or sphere, or for r = 0 a single point."""
    d = len(centre)
    out = np.zeros((3,) * d)
    out[(0,) * d] = centre @ centre - radius**2
    for axis, c in enumerate(centre):
        at = np.eye(d, dtype=int)[axis]
        out[tuple(at)] = -2.0 * c
        out[tuple(2 * at)] = 1.0
    return out


def sheet(dimension: int, axis: int, place: float) -> FloatArray:
    """Return the tensor of x_k − p: a line or plane."""
    out = np.zeros((2,) * dimension)
    out[(0,) * dimension] = -place
    out[tuple(np.eye(dimension, dtype=int)[axis])] = 1.0
    return out


def deceivers(shape: shapes.Shape, data: FloatArray, count: int) -> Iterator[ImplicitPolynomial]:
    """Yield shapes times tiny balls, points, and sheets along walls, of 1e-6 … 0.1, outside the tube about the data."""
    d, (lower, upper) = shape.polynomial.dimension, shape.polynomial.bounds
    rng, made, away = np.random.default_rng(d), 0, 1.1 * Tube(data).radius
    while made < count:
        centre = rng.uniform(lower, upper)
        if np.linalg.norm(data - centre, axis=1).min() < away:
            continue
        kind, radius = made % 3, 10.0 ** rng.uniform(-6, -1)
        if kind == 2:
            axis = int(rng.integers(d))
            factor = sheet(d, axis, lower[axis] + radius if rng.random() < 0.5 else upper[axis] - radius)
        else:
            factor = ball(centre, radius if kind == 0 else 0.0)
        yield times(shape.polynomial, factor)
        made += 1
