"""Moments of many points, and the Gram matrix gathered from them."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from ipcore.polynomial import graded, gram, univariate
from ipcore.polynomial.univariate import Basis

EPS = float(np.finfo(float).eps)
DEGREE, COUNT = 12, 8192


def test_moments(benchmark: BenchmarkFixture) -> None:
    t = np.random.default_rng(0).uniform(-1.0, 1.0, (3, COUNT))
    tables = [univariate.table(Basis.CHEBYSHEV, row, 2 * DEGREE) for row in t]
    mu = benchmark(gram.moments, tables, np.ones((1, COUNT)))
    few = np.arange(0, len(mu), 97)
    direct = graded.products(tables, gram.order(3, 2 * DEGREE)[few]).sum(axis=1)
    np.testing.assert_allclose(mu[few, 0], direct, atol=8.0 * EPS * COUNT)


def test_gram_from_moments(benchmark: BenchmarkFixture) -> None:
    t = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 500))
    tables = [univariate.table(Basis.CHEBYSHEV, row, 2 * DEGREE) for row in t]
    mu = gram.moments(tables, np.ones((1, 500)))
    G = benchmark(gram.gram, mu, 3, DEGREE)[0]
    P = graded.products([table[: DEGREE + 1] for table in tables], graded.exponents(3, DEGREE))
    np.testing.assert_allclose(G, P @ P.T, atol=8.0 * EPS * 500.0)
