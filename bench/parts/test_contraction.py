"""f and ∇f by contraction, at scattered points and on a grid."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from ipcore._typing import FloatArray
from ipcore.polynomial import evaluation, graded, univariate
from zero_sets import bumpy

EPS = float(np.finfo(float).eps)
COUNT, LINES = 8192, 64


def test_scattered(benchmark: BenchmarkFixture) -> None:
    p = bumpy(3)
    x = np.random.default_rng(0).uniform(-1.5, 1.5, (COUNT, 3))
    f, gradient = benchmark(p.value_and_gradient, x)
    np.testing.assert_allclose(f, term_by_term(x), atol=64.0 * EPS * np.abs(p.coefficients).sum())
    h = 1e-6
    step = h * np.eye(3)[0]
    slope = (p(x[:100] + step) - p(x[:100] - step)) / (2.0 * h)
    size = np.abs(p.coefficients).sum()
    # central differences: third derivatives are at most n⁶/15 times the sum of coefficients in the box of half 1.5
    np.testing.assert_allclose(gradient[:100, 0], slope, atol=size * (p.degree**6 * h**2 / 90.0 + 64.0 * EPS / h))


def test_on_a_grid(benchmark: BenchmarkFixture) -> None:
    p = bumpy(3)
    line = np.linspace(-1.5, 1.5, LINES)
    f = benchmark(evaluation.along_axes, p.tensor, p.tables([line] * 3))
    x = np.stack(np.meshgrid(line[::8], line[::8], line[::8], indexing="ij"), axis=-1).reshape(-1, 3)
    tolerance = 64.0 * EPS * np.abs(p.coefficients).sum()
    np.testing.assert_allclose(f[::8, ::8, ::8].ravel(), term_by_term(x), atol=tolerance)


def term_by_term(x: FloatArray) -> FloatArray:
    p = bumpy(3)
    tables = [univariate.table(p.basis, np.ascontiguousarray(row), p.degree) for row in (x / 1.5).T]
    return np.asarray(p.coefficients @ graded.products(tables, p.exponents))
