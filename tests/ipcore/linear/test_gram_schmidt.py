import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.linear.qr.gram_schmidt import GramSchmidt
from ipcore.options.choices import Collinear
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.univariate import Basis

EPS = np.finfo(float).eps


def system(degree: int) -> tuple[FloatArray, FloatArray]:
    generator = np.random.default_rng(0)
    angle, radius = generator.uniform(0.0, 2.0 * np.pi, 900), generator.uniform(0.9, 1.1, 900)
    x = np.column_stack([radius * np.cos(angle), 0.7 * radius * np.sin(angle)])
    tables = [univariate.table(Basis.MONOMIAL, row.copy(), degree) for row in x.T]
    return graded.products(tables, graded.exponents(2, degree)).T, np.cos(3.0 * x[:, 0]) - x[:, 1]


def test_it_is_equation_5_as_printed() -> None:
    M, b = system(3)
    factor = GramSchmidt(b, Policy(0.0))
    factor.append(M)
    q: list[FloatArray] = []
    for c in M.T:  # the paper's formulas, one by one
        r = [qj @ c for qj in q]
        left = c - sum((rj * qj for rj, qj in zip(r, q, strict=True)), start=np.zeros_like(c))
        r.append(np.linalg.norm(left))
        q.append(left / r[-1])
        np.testing.assert_allclose(factor.R[: len(r), len(r) - 1], r, atol=100 * EPS * np.linalg.norm(c))
        assert abs(factor.rhs[len(r) - 1] - q[-1] @ b) < 100 * EPS * np.linalg.norm(b)


def test_column_by_column_is_the_same_as_all_at_once() -> None:
    M, b = system(6)
    one, all_ = GramSchmidt(b, Policy(1e-12)), GramSchmidt(b, Policy(1e-12))
    all_.append(M)
    for k in range(M.shape[1]):
        one.append(M[:, k : k + 1])
        np.testing.assert_array_equal(one.R, all_.R[: k + 1, : k + 1])
        np.testing.assert_array_equal(one.rhs, all_.rhs[: k + 1])


def test_the_measured_loss_is_the_true_one_and_grows_with_the_square_of_the_condition() -> None:
    losses = []
    for degree in (4, 8, 12):
        M, b = system(degree)
        factor = GramSchmidt(b, Policy(0.0))
        factor.append(M)
        k = M.shape[1]
        Q = M @ np.linalg.inv(factor.R)
        loss = factor.orthogonality_loss(k)
        losses.append(loss)
        condition = np.linalg.cond(M / np.linalg.norm(M, axis=0))
        assert loss < 100 * EPS * k * condition**2
        if degree == 4:
            assert abs(loss - np.linalg.norm(Q.T @ Q - np.eye(k), 2)) < 1000 * EPS * condition
        assert BlockGramSchmidt(b, Policy(0.0)).orthogonality_loss(k) is None
    assert losses[0] < 1e-10
    assert losses[0] < losses[1] / 1e3 < losses[2] / 1e6


def test_while_it_is_orthogonal_it_solves_the_least_squares_problem() -> None:
    M, b = system(5)
    factor = GramSchmidt(b, Policy(1e-12))
    factor.append(M)
    direct = np.linalg.lstsq(M, b)[0]
    np.testing.assert_allclose(factor.solve(), direct, rtol=1e-8, atol=1e-9)
    assert factor.rss == pytest.approx(float(((M @ direct - b) ** 2).sum()), rel=1e-10)


def test_the_residual_is_that_of_the_delivered_solution_even_when_orthogonality_is_lost() -> None:
    M, b = system(14)
    factor = GramSchmidt(b, Policy(0.0))
    factor.append(M)
    assert factor.orthogonality_loss(M.shape[1]) > 1e-3
    left = b - M @ factor.solve()
    np.testing.assert_allclose(factor.residual, left, atol=1e-6 * float(np.linalg.norm(b)))


@pytest.mark.parametrize("kind", [GramSchmidt, BlockGramSchmidt])
def test_collinear_columns_are_dropped_damped_or_kept(kind: type[GramSchmidt] | type[BlockGramSchmidt]) -> None:
    M, b = system(4)
    doubled = np.hstack([M[:, :6], M[:, 1:2] + 2.0 * M[:, 3:4], M[:, 6:]])
    k, d = doubled.shape[1], np.full(doubled.shape[1], 1e-2)
    dropped = kind(b, Policy(1e-12))
    dropped.append(doubled, None)
    assert np.flatnonzero(~dropped.kept).tolist() == [6]
    assert dropped.solve()[6] == 0.0
    damped = kind(b, Policy(1e-12, Collinear.RIDGE), k)
    damped.append(doubled, d)
    assert damped.kept.all()
    assert damped.ridged == 1
    D = np.zeros((1, k))
    D[0, 6] = 0.1
    direct = np.linalg.lstsq(np.vstack([doubled, D]), np.append(b, 0.0))[0]
    np.testing.assert_allclose(damped.solve(), direct, atol=1e-9 * np.abs(direct).max())
    kept = kind(b, Policy(1e-12, Collinear.KEEP))
    kept.append(doubled)
    assert kept.kept.all()
    assert kept.condition() > 1e14
