"""Block Gram–Schmidt done twice, form by form."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.polynomial import graded

EPS = float(np.finfo(float).eps)
DEGREE, ROWS = 10, 10_000


def test_block_gram_schmidt(benchmark: BenchmarkFixture) -> None:
    generator = np.random.default_rng(0)
    M = np.asfortranarray(generator.normal(size=(ROWS, graded.count(3, DEGREE))))
    M[:, 1:] += 1e3 * M[:, :1]  # a condition of 1e3 or more, so that one pass would not do
    b = generator.normal(size=ROWS)

    def work() -> BlockGramSchmidt:
        factor = BlockGramSchmidt(b, Policy(0.0))
        for degree in range(DEGREE + 1):
            factor.append(M[:, graded.form(3, degree)])
        return factor

    factor = benchmark(work)
    Q = np.hstack(factor.q_blocks())
    size = np.sqrt(Q.shape[1])
    assert np.linalg.norm(Q.T @ Q - np.eye(Q.shape[1])) <= 16.0 * EPS * size
    np.testing.assert_allclose(Q @ factor.R, M, atol=16.0 * EPS * size * np.linalg.norm(M, axis=0).max())
