r"""Whether a zero set is bounded: whether the leading form is definite.

Far out f behaves as its leading form L_n, the terms of the highest degree, along every ray. If L_n has one sign in all
directions, so has f beyond some radius, and no part of the zero set runs to infinity (Tasdizen, Tarel and Cooper 2000).
L_n(−x) = (−1)^n L_n(x), so an odd degree is never bounded in this sense.
"""

import numpy as np
from scipy.optimize import minimize

from ipcore._typing import FloatArray, IntArray
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.box import Box
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis

# A form whose least value is less than this share of its greatest counts as touching 0: coefficients carry the rounding
# of an ill-conditioned solve.
TOUCHING = 1e-12
# Directions per degree along a great circle: with 8, nothing between two of them rises by more than about 2 % of the
# form's greatest value (Bernstein: the second derivative along a circle is at most n² times that).
PER_DEGREE = 8
# How many of the lowest directions on the sphere are followed downhill.
STARTS = 8


def is_bounded(polynomial: ImplicitPolynomial) -> bool:
    """Return whether the leading form is definite, so that the zero set is bounded.

    >>> from ipcore import shapes
    >>> is_bounded(shapes.torus().polynomial), is_bounded(shapes.cubic().polynomial)
    (True, False)
    """
    powers, coefficients = leading_form(polynomial)
    if int(powers[0].sum()) % 2 == 1 or not coefficients.any():
        return False
    values = _values(powers, coefficients, _directions(powers))
    largest = np.abs(values).max()
    sign = np.sign(values[np.argmax(np.abs(values))])
    lowest = (sign * values).min()
    if polynomial.dimension == 3 and lowest > 0.0:
        lowest = _minimum_on_sphere(powers, sign * coefficients)
    if polynomial.dimension == 2 and lowest > 0.0:
        lowest = (sign * _values(powers, coefficients, _critical_directions(powers, coefficients))).min()
    return bool(lowest > TOUCHING * largest)


def leading_form(polynomial: ImplicitPolynomial) -> tuple[IntArray, FloatArray]:
    """Return exponents (k, d) and coefficients (k,), monomials of the frame, of the highest form that is not all 0.

    A Chebyshev product T_i T_j T_k contributes its own highest term alone: 2^(i−1) t^i for i ≥ 1 along each axis.
    """
    d, a = polynomial.dimension, polynomial.coefficients
    degree = polynomial.degree
    while degree and not a[graded.form(d, degree)].any():
        degree -= 1
    part = graded.form(d, degree)
    powers, leading = polynomial.exponents[part], a[part].copy()
    if polynomial.basis is Basis.CHEBYSHEV:
        slopes = polynomial.frame.scale / Box.of(polynomial.bounds).half
        leading *= (2.0 ** np.maximum(powers - 1, 0) * slopes**powers).prod(axis=1)
    return powers, leading


def _values(powers: IntArray, coefficients: FloatArray, x: FloatArray) -> FloatArray:
    """Return the form at x (M, d), shape (M,)."""
    degree = int(powers[0].sum())
    tables = [univariate.table(Basis.MONOMIAL, column, degree) for column in x.T]
    return np.asarray(coefficients @ graded.products(tables, powers))


def _directions(powers: IntArray) -> FloatArray:
    """Return unit directions (M, d), close enough together to miss nothing wide: half a circle, or a half sphere."""
    degree, d = int(powers[0].sum()), powers.shape[1]
    angle = np.pi * np.arange(PER_DEGREE * degree) / (PER_DEGREE * degree)
    half_circle = np.column_stack([np.cos(angle), np.sin(angle)])
    if d == 2:
        return half_circle
    height = np.cos(angle)[:, None]  # x and −x agree, so half of the longitudes do
    ring = np.sin(angle)[:, None, None] * half_circle
    sphere = np.concatenate([ring, np.broadcast_to(height[:, None], (*ring.shape[:2], 1))], axis=2)
    return sphere.reshape(-1, 3)


def _critical_directions(powers: IntArray, coefficients: FloatArray) -> FloatArray:
    """Return directions (M, 2) among which a form of two variables takes either sign that it takes at all.

    On the unit circle L_n(cos θ, sin θ) = Σ_k c_k e^{i(n−2k)θ}, so with z = e^{2iθ} its real roots are the roots on
    |z| = 1 of a polynomial of degree n, which is far better conditioned than L_n(1, t). Their own directions and those
    half way between any two are looked at, so no root has to be told from one that is near the circle.
    """
    degree = int(powers[0].sum())
    theta = np.pi * np.arange(degree + 1) / (degree + 1)
    samples = _values(powers, coefficients, np.column_stack([np.cos(theta), np.sin(theta)]))
    spectrum = np.fft.fft(samples * np.exp(1j * degree * theta)) / (degree + 1)
    found = np.sort(np.angle(np.roots(spectrum[::-1]))) / 2.0
    between = (found + np.append(found[1:], found[:1] + np.pi)) / 2.0
    angle = np.concatenate([found, between, [0.0]])
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _minimum_on_sphere(powers: IntArray, coefficients: FloatArray) -> float:
    """Return the least value on the unit sphere: the lowest of many directions, followed downhill."""
    directions = _directions(powers)
    lowest = directions[np.argsort(_values(powers, coefficients, directions), kind="stable")[:STARTS]]
    scale = float(np.abs(coefficients).max())

    def value(x: FloatArray) -> tuple[float, FloatArray]:
        return _on_sphere(powers, coefficients / scale, x)

    return scale * min(float(minimize(value, x, jac=True, method="BFGS", tol=1e-14).fun) for x in lowest)


def _on_sphere(powers: IntArray, coefficients: FloatArray, x: FloatArray) -> tuple[float, FloatArray]:
    """Return L(x/‖x‖) and its gradient (d,) with respect to x, which is tangential: (∇L(u) − n L(u) u)/‖x‖."""
    length = float(np.linalg.norm(x))
    u = x / length
    value = float(coefficients @ (u**powers).prod(axis=1))
    lowered = np.maximum(powers[None] - np.eye(len(x), dtype=np.intp)[:, None], 0)
    gradient = ((u**lowered).prod(axis=2) * powers.T) @ coefficients
    return value, (gradient - powers[0].sum() * value * u) / length
