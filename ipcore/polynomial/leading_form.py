r"""Whether a zero set is bounded: whether the leading form is definite.

Far from the origin f behaves along every ray as its leading form L_n, the terms of the highest degree. If L_n has the
same sign in all directions, so has f beyond some radius, and no part of the zero set extends to infinity (Tasdizen,
Tarel and Cooper 2000). L_n(−x) = (−1)^n L_n(x), so with an odd degree the zero set is not bounded in this sense.
"""

import numpy as np
import scipy

from ipcore._typing import FloatArray, IntArray
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.box import Box
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis

# A form whose least value is below this share of its greatest counts as reaching 0: the coefficients have the rounding
# errors of an ill-conditioned solve.
DEFINITE = 1e-12
# Directions per degree along half a great circle: with 8, no value between two of them exceeds both by more than about
# 2 % of the greatest value (Bernstein: the second derivative along a circle is at most n² times that).
DIRECTIONS_PER_DEGREE = 8
STARTS = 8  # the number of directions on the sphere with the least values from which the minimum is searched


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
    return bool(lowest > DEFINITE * largest)


def leading_form(polynomial: ImplicitPolynomial) -> tuple[IntArray, FloatArray]:
    """Return the highest form that is not 0, in monomials of the frame: exponents (k, d) and coefficients (k,).

    Of a Chebyshev product T_i T_j T_k only its highest term counts: 2^(i−1) t^i for i ≥ 1 along each axis.
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
    """Return the values (M,) of a form at x (M, d), given its exponents `powers` (k, d) and coefficients (k,)."""
    degree = int(powers[0].sum())
    tables = [univariate.table(Basis.MONOMIAL, column, degree) for column in x.T]
    return np.asarray(coefficients @ graded.products(tables, powers))


def _directions(powers: IntArray) -> FloatArray:
    """Return unit directions (M, d) on half a circle or half a sphere, as dense as forms of this degree need."""
    degree, d = int(powers[0].sum()), powers.shape[1]
    angle = np.pi * np.arange(DIRECTIONS_PER_DEGREE * degree) / (DIRECTIONS_PER_DEGREE * degree)
    half_circle = np.column_stack([np.cos(angle), np.sin(angle)])
    if d == 2:
        return half_circle
    height = np.cos(angle)[:, None]  # at x and −x the values are equal, so half of the longitudes suffice
    ring = np.sin(angle)[:, None, None] * half_circle
    sphere = np.concatenate([ring, np.broadcast_to(height[:, None], (*ring.shape[:2], 1))], axis=2)
    return sphere.reshape(-1, 3)


def _critical_directions(powers: IntArray, coefficients: FloatArray) -> FloatArray:
    """Return directions (M, 2) in which a form of two variables takes every sign that it takes anywhere.

    On the unit circle L_n(cos θ, sin θ) = Σ_k c_k e^{i(n−2k)θ}, so with z = e^{2iθ} its real roots are the roots on
    |z| = 1 of a polynomial of degree n, which is far better conditioned than L_n(1, t). The directions returned are
    those of all roots and those half way between neighbours, so it need not be decided which roots lie on the circle.
    """
    degree = int(powers[0].sum())
    theta = np.pi * np.arange(degree + 1) / (degree + 1)
    samples = _values(powers, coefficients, np.column_stack([np.cos(theta), np.sin(theta)]))
    spectrum = np.fft.fft(samples * np.exp(1j * degree * theta)) / (degree + 1)
    roots = np.sort(np.angle(np.roots(spectrum[::-1]))) / 2.0
    between = (roots + np.append(roots[1:], roots[:1] + np.pi)) / 2.0
    angle = np.concatenate([roots, between, [0.0]])
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _minimum_on_sphere(powers: IntArray, coefficients: FloatArray) -> float:
    """Return the least value of a form on the unit sphere, searched from the `STARTS` lowest of many directions."""
    directions = _directions(powers)
    lowest = directions[np.argsort(_values(powers, coefficients, directions), kind="stable")[:STARTS]]
    scale = float(np.abs(coefficients).max())

    def value(x: FloatArray) -> tuple[float, FloatArray]:
        return _on_sphere(powers, coefficients / scale, x)

    return scale * min(float(scipy.optimize.minimize(value, x, jac=True, method="BFGS", tol=1e-14).fun) for x in lowest)


def _on_sphere(powers: IntArray, coefficients: FloatArray, x: FloatArray) -> tuple[float, FloatArray]:
    """Return L(u), u = x/‖x‖, and its gradient (d,) with respect to x (d,): (∇L(u) − n L(u) u)/‖x‖.

    The gradient is tangential, for u·∇L(u) = n L(u) by Euler's theorem.
    """
    length = float(np.linalg.norm(x))
    u = x / length
    value = float(coefficients @ (u**powers).prod(axis=1))
    lowered = np.maximum(powers[None] - np.eye(len(x), dtype=np.intp)[:, None], 0)
    gradient = ((u**lowered).prod(axis=2) * powers.T) @ coefficients
    return value, (gradient - powers[0].sum() * value * u) / length
