from collections.abc import Callable

import numpy as np
import pytest

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.leading_form import _on_sphere, is_bounded, leading_form
from ipcore.polynomial.univariate import Basis

EVERY = [*shapes.CURVES, *shapes.SURFACES]


def polynomial(function: Callable[[FloatArray], FloatArray], dimension: int, degree: int) -> ImplicitPolynomial:
    """Return the polynomial that takes a function's values, turned by some rotation, off centre."""
    generator = np.random.default_rng(degree)
    rotation = np.linalg.qr(generator.normal(size=(dimension, dimension)))[0]
    x = generator.uniform(-1.0, 1.0, (4 * graded.count(dimension, degree), dimension))
    powers = graded.exponents(dimension, degree)
    M = (x[:, None, :] ** powers).prod(axis=2)
    a = np.linalg.lstsq(M, function(x @ rotation))[0]
    bounds = np.array([[-1.5] * dimension, [1.0] * dimension])
    return ImplicitPolynomial(degree, a, Frame(np.zeros(dimension), 1.0), bounds)


@pytest.mark.parametrize("make", EVERY)
def test_shapes_are_bounded_but_the_cubic(make: Callable[[], shapes.Shape]) -> None:
    assert is_bounded(make().polynomial) == (make is not shapes.cubic)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("least", [1e-6, -1e-6])
def test_definite_is_told_from_indefinite_by_a_millionth(dimension: int, least: float) -> None:
    form = polynomial(lambda u: (u[:, 1:] ** 2).sum(axis=1) ** 2 + least * (u**2).sum(axis=1) ** 2, dimension, 4)
    assert is_bounded(form) == (least > 0.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_form_that_touches_zero_is_not_definite(dimension: int) -> None:
    touching = polynomial(lambda u: u[:, 1] ** 4 + (u[:, -1] ** 2) * (u**2).sum(axis=1), dimension, 4)
    assert not is_bounded(touching)


@pytest.mark.parametrize("dimension", [2, 3])
def test_negative_definite_forms_are_bounded_and_odd_degrees_never(dimension: int) -> None:
    assert is_bounded(polynomial(lambda u: u[:, 0] - (u**2).sum(axis=1), dimension, 2))
    assert not is_bounded(polynomial(lambda u: u[:, 0] ** 3, dimension, 3))


def test_what_lies_above_the_leading_form_does_not_count() -> None:
    ellipse = shapes.ellipse().polynomial
    padded = ImplicitPolynomial(3, np.append(ellipse.coefficients, np.zeros(4)), ellipse.frame, ellipse.bounds)
    assert is_bounded(padded)
    assert leading_form(padded)[0].tolist() == [[2, 0], [1, 1], [0, 2]]


@pytest.mark.parametrize("dimension", [2, 3])
def test_both_bases_have_the_same_leading_form(dimension: int) -> None:
    plain = polynomial(lambda u: u[:, 0] ** 5 - u[:, 1] ** 3 * u[:, -1] ** 2 + u[:, 0], dimension, 5)
    products = plain.to_chebyshev()
    assert products.basis is Basis.CHEBYSHEV
    np.testing.assert_allclose(leading_form(products)[1], leading_form(plain)[1], atol=1e-13)


@pytest.mark.parametrize("degree", [6, 12, 20])
def test_a_high_degree_with_one_thin_negative_cone_is_found(degree: int) -> None:
    generator = np.random.default_rng(degree)
    axis = generator.normal(size=3)
    axis /= np.linalg.norm(axis)
    powers = graded.exponents(3, degree)[graded.form(3, degree)]
    weights = np.array([np.prod([_factorial(p) for p in row]) / _factorial(degree) for row in powers.tolist()])
    radius = np.array([_power_of_radius(row, degree) for row in powers.tolist()])
    for depth, bounded in ((0.999, True), (1.001, False)):  # r^n − depth · (axis·x)^n, least along the axis
        a = np.zeros(graded.count(3, degree))
        a[graded.form(3, degree)] = radius - depth * (axis**powers).prod(axis=1) / weights
        form = ImplicitPolynomial(degree, a, Frame(np.zeros(3), 1.0), np.array([[-1.0] * 3, [1.0] * 3]))
        assert is_bounded(form) == bounded


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("length", [0.4, 1.0, 2.5])
def test_the_gradient_on_the_sphere_is_that_of_finite_differences_and_tangential(dimension: int, length: float) -> None:
    generator = np.random.default_rng(dimension)
    powers = graded.exponents(dimension, 6)[graded.form(dimension, 6)]
    coefficients, x, h = generator.normal(size=len(powers)), generator.normal(size=dimension), 1e-5
    x *= length / np.linalg.norm(x)
    value, gradient = _on_sphere(powers, coefficients, x)
    assert value == pytest.approx(float((x**powers).prod(axis=1) @ coefficients) / length**6, rel=1e-12)
    steps = h * np.eye(dimension)
    slopes = [
        (_on_sphere(powers, coefficients, x + e)[0] - _on_sphere(powers, coefficients, x - e)[0]) / (2.0 * h)
        for e in steps
    ]
    size = float(np.linalg.norm(gradient))
    assert size > 0.1
    np.testing.assert_allclose(gradient, slopes, atol=1e-6 * size)  # h² times the third derivative, and ε/h
    assert abs(float(gradient @ x)) < 1e-13 * size * length


def _factorial(n: int) -> float:
    return float(np.prod(np.arange(1, n + 1, dtype=float)))


def _power_of_radius(powers: list[int], degree: int) -> float:
    """Return the coefficient of x^i y^j z^k in (x² + y² + z²)^(n/2)."""
    if any(p % 2 for p in powers):
        return 0.0
    return _factorial(degree // 2) / float(np.prod([_factorial(p // 2) for p in powers]))
