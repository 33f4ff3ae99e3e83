import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.polynomial import evaluation, graded, gram, univariate
from ipcore.polynomial.univariate import Basis

EPS = np.finfo(float).eps
DEGREE = {2: 9, 3: 6}


def tables(t: FloatArray, degree: int) -> list[FloatArray]:
    return [univariate.table(Basis.CHEBYSHEV, row, degree) for row in t]


@pytest.mark.parametrize("d", [2, 3])
def test_gram_matrices_from_moments_are_those_of_the_products(d: int) -> None:
    generator, n = np.random.default_rng(0), DEGREE[d]
    t, weights = generator.uniform(-1.0, 1.0, (d, 5000)), generator.normal(size=(3, 5000))
    G = gram.gram(gram.moments(tables(t, 2 * n), weights), d, n)
    P = graded.products(tables(t, n), graded.exponents(d, n))
    for weight, one in zip(weights, G, strict=True):
        np.testing.assert_allclose(one, (P * weight) @ P.T, atol=8.0 * EPS * np.abs(weight).sum())


@pytest.mark.parametrize("d", [2, 3])
def test_moments_of_two_sets_add(d: int) -> None:
    t = np.random.default_rng(0).uniform(-1.0, 1.0, (d, 700))
    ones = np.ones((1, 700))
    whole = gram.moments(tables(t, 8), ones)
    parts = gram.moments(tables(t[:, :300], 8), ones[:, :300]) + gram.moments(tables(t[:, 300:], 8), ones[:, 300:])
    np.testing.assert_allclose(parts, whole, atol=700.0 * EPS * 8.0)


@pytest.mark.parametrize("d", [2, 3])
def test_moments_on_a_grid_are_those_of_its_nodes(d: int) -> None:
    line = np.linspace(-1.0, 1.0, 7)
    weights = np.random.default_rng(0).uniform(size=(7,) * d)
    t = np.stack(np.meshgrid(*[line] * d, indexing="ij")).reshape(d, -1)
    scattered = gram.moments(tables(t, 6), weights.reshape(1, -1))
    on_grid = gram.grid_moments(weights, univariate.table(Basis.CHEBYSHEV, line, 6))
    np.testing.assert_allclose(on_grid, scattered, atol=16.0 * EPS * weights.sum())


@pytest.mark.parametrize("d", [2, 3])
def test_every_moment_has_its_position_and_its_graded_place(d: int) -> None:
    exponents = gram.order(d, 5)
    assert gram.position(exponents, 5).tolist() == list(range(len(exponents)))
    mu = np.arange(float(len(exponents)))[:, None]
    places = gram.in_graded_order(mu, d, 5)[:, 0].astype(int)
    np.testing.assert_array_equal(exponents[places], graded.exponents(d, 5))


@pytest.mark.parametrize("d", [2, 3])
def test_differentiation_matrices_differentiate(d: int) -> None:
    generator, n = np.random.default_rng(0), 5
    a, t, h = generator.normal(size=graded.count(d, n)), generator.uniform(-0.9, 0.9, (d, 20)), 1e-6

    def value(coefficients: FloatArray, at: FloatArray) -> FloatArray:
        return np.asarray(evaluation.scattered(evaluation.to_tensor(coefficients, d, n)[None], tables(at, n))[0])

    for axis in range(d):
        step = h * np.eye(d)[:, axis : axis + 1]
        expected = (value(a, t + step) - value(a, t - step)) / (2.0 * h)
        # central differences: third derivatives, at most n⁶/15 times the sum of coefficients, times h²/6; and rounding
        tolerance = np.abs(a).sum() * (n**6 * h**2 / 90.0 + 4.0 * EPS / h)
        slope = np.asarray(gram.differentiation(d, n, axis) @ a)
        np.testing.assert_allclose(value(slope, t), expected, atol=tolerance)
