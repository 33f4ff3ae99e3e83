import json

import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.errors import InvalidPointsError, InvalidPolynomialError
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis

CASES = [(2, 1), (2, 7), (3, 2), (3, 6)]


def some_polynomial(dimension: int, degree: int, kind: Basis = Basis.MONOMIAL) -> ImplicitPolynomial:
    """Return a polynomial in an awkward frame: off centre, scaled, with unequal bounds."""
    generator = np.random.default_rng(degree)
    frame = Frame(np.array([30.0, -7.0, 2.0][:dimension]), 2.5)
    bounds = np.stack([frame.centre - 4.0, frame.centre + 5.0 + np.arange(dimension)])
    a = generator.normal(size=graded.count(dimension, degree))
    return ImplicitPolynomial(degree, a, frame, bounds, kind)


def some_points(p: ImplicitPolynomial, count: int = 40) -> FloatArray:
    return np.random.default_rng(5).uniform(p.bounds[0], p.bounds[1], (count, p.dimension))


@pytest.mark.parametrize(("dimension", "degree"), CASES)
def test_value_is_the_contracts_sentence(dimension: int, degree: int) -> None:
    p = some_polynomial(dimension, degree)
    x = some_points(p)
    u = (x - p.frame.centre) / p.frame.scale
    terms = p.coefficients * (u[:, None, :] ** p.exponents).prod(axis=2)
    np.testing.assert_allclose(p(x), terms.sum(axis=1), atol=1e-14 * np.abs(terms).sum(axis=1).max())


@pytest.mark.parametrize("kind", list(Basis))
@pytest.mark.parametrize(("dimension", "degree"), CASES)
def test_derivatives_are_limits_of_differences(dimension: int, degree: int, kind: Basis) -> None:
    p = some_polynomial(dimension, degree, kind)
    x, h = some_points(p), 1e-5
    steps = h * np.eye(dimension)
    gradient = np.stack([(p(x + e) - p(x - e)) / (2 * h) for e in steps], axis=1)
    hessian = np.stack([(p.gradient(x + e) - p.gradient(x - e)) / (2 * h) for e in steps], axis=1)
    size = np.abs(p.gradient(x)).max()
    np.testing.assert_allclose(p.gradient(x), gradient, atol=1e-7 * size)
    np.testing.assert_allclose(p.hessian(x), hessian, atol=1e-6 * size)
    f, both = p.value_and_gradient(x)
    np.testing.assert_allclose(f, p(x), rtol=1e-12, atol=1e-12 * np.abs(f).max())
    np.testing.assert_allclose(both, p.gradient(x), rtol=1e-12, atol=1e-12 * size)


@pytest.mark.parametrize(("dimension", "degree"), CASES)
def test_monomial_form_of_a_chebyshev_polynomial_is_the_same_polynomial(dimension: int, degree: int) -> None:
    p = some_polynomial(dimension, degree, Basis.CHEBYSHEV)
    q = p.to_monomial()
    x = some_points(p)
    assert q.basis is Basis.MONOMIAL
    np.testing.assert_allclose(q(x), p(x), atol=1e-11 * np.abs(p.coefficients).sum())
    assert q.to_monomial() is q


def test_grid_agrees_with_scattered_points_and_chunks_do_not_show() -> None:
    p = some_polynomial(3, 5, Basis.CHEBYSHEV)
    axes = [np.linspace(low, high, count) for low, high, count in zip(*p.bounds, (11, 12, 13), strict=True)]
    scattered = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)  # 1,716 points: more than a chunk
    np.testing.assert_allclose(p.on_grid(axes).ravel(), p(scattered), atol=1e-12 * np.abs(p.coefficients).sum())


def test_distance_of_a_circle() -> None:
    box = np.array([[-3.0, -3.0], [3.0, 3.0]])
    circle = ImplicitPolynomial(2, np.array([-4.0, 0, 0, 1, 0, 1]), Frame(np.zeros(2), 1.0), box)
    near = np.array([[2.001, 0.0], [0.0, -1.999], [0.0, 0.0]])
    np.testing.assert_allclose(circle.distance(near)[:2], [1e-3, -1e-3], rtol=1e-3)
    assert circle.distance(near)[2] == -np.inf  # the gradient vanishes at the centre
    assert circle.contains(np.array([[0.0, 3.0], [0.0, 3.1]])).tolist() == [True, False]


def test_distance_is_zero_where_value_and_gradient_vanish() -> None:
    box = np.array([[-1.0, -1.0], [1.0, 1.0]])
    cross = ImplicitPolynomial(2, np.array([0.0, 0, 0, 0, 1, 0]), Frame(np.zeros(2), 1.0), box)
    assert cross.distance(np.zeros((1, 2))).tolist() == [0.0]


@pytest.mark.parametrize("kind", list(Basis))
def test_dict_survives_json_bit_for_bit(kind: Basis) -> None:
    p = some_polynomial(3, 4, kind)
    q = ImplicitPolynomial.from_dict(json.loads(json.dumps(p.to_dict())))
    np.testing.assert_array_equal(q.coefficients, p.coefficients)
    np.testing.assert_array_equal(q.bounds, p.bounds)
    assert (q.degree, q.basis, q.frame.scale) == (p.degree, p.basis, p.frame.scale)


def test_dict_may_list_exponents_in_any_order_and_leave_zeros_out() -> None:
    parts = some_polynomial(2, 2).to_dict() | {"exponents": [[0, 2], [0, 0], [2, 0]], "coefficients": [1, -1, 1]}
    assert ImplicitPolynomial.from_dict(parts).coefficients.tolist() == [-1, 0, 0, 1, 0, 1]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"coefficients": [1.0]}, "one row"),
        ({"exponents": [[3, 0]] * 6}, "total degree 0 to 2"),
        ({"exponents": [[-1, 0]] * 6}, "total degree 0 to 2"),
        ({"coefficients": [float("nan")] * 6}, "finite"),
        ({"bounds": [[0, 0], [0, 1]]}, "upper corner"),
        ({"frame": {"centre": [0, 0], "scale": 0}}, "positive"),
        ({"frame": {"centre": [0, 0]}}, "scale"),
        ({"basis": "fourier"}, "fourier"),
        ({"degree": 3}, ""),
    ],
)
def test_parts_that_make_no_polynomial_are_refused(change: dict[str, object], says: str) -> None:
    parts = some_polynomial(2, 2).to_dict() | change
    if change == {"degree": 3}:  # fewer coefficients than degree 3 has are no fault: missing ones are 0
        assert len(ImplicitPolynomial.from_dict(parts).coefficients) == graded.count(2, 3)
        return
    with pytest.raises(InvalidPolynomialError, match=says):
        ImplicitPolynomial.from_dict(parts)


def test_wrong_number_of_coefficients_is_refused() -> None:
    with pytest.raises(InvalidPolynomialError, match="6 coefficients, not 5"):
        ImplicitPolynomial(2, np.ones(5), Frame(np.zeros(2), 1.0), np.array([[0.0, 0.0], [1.0, 1.0]]))


def test_points_of_another_dimension_are_refused() -> None:
    with pytest.raises(InvalidPointsError, match=r"shape \(M, 2\), not \(4, 3\)"):
        some_polynomial(2, 2)(np.zeros((4, 3)))
