import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.univariate import Basis

EPS = np.finfo(float).eps


def monomial_system(degree: int) -> tuple[FloatArray, FloatArray, list[slice]]:
    """Return an ill-conditioned M, as of points near a curve, a right-hand side, and the forms."""
    generator = np.random.default_rng(0)
    angle, radius = generator.uniform(0.0, 2.0 * np.pi, 900), generator.uniform(0.9, 1.1, 900)
    x = np.column_stack([radius * np.cos(angle), 0.7 * radius * np.sin(angle)])
    tables = [univariate.table(Basis.MONOMIAL, row.copy(), degree) for row in x.T]
    M = graded.products(tables, graded.exponents(2, degree)).T
    return M, np.cos(3.0 * x[:, 0]) - x[:, 1], [graded.form(2, s) for s in range(degree + 1)]


def factored(M: FloatArray, b: FloatArray, blocks: list[slice], tolerance: float = 1e-13) -> BlockGramSchmidt:
    factor = BlockGramSchmidt(b, Policy(tolerance))
    for block in blocks:
        factor.append(M[:, block])
    return factor


def test_q_is_orthonormal_to_rounding_where_one_pass_is_not() -> None:
    M, b, forms = monomial_system(14)
    factor = factored(M, b, forms)
    Q = np.hstack(factor._Q.blocks())  # noqa: SLF001 - Q itself is not part of the interface
    assert np.linalg.norm(Q.T @ Q - np.eye(Q.shape[1]), 2) < 100 * EPS
    assert np.linalg.norm(Q @ factor.R - M, axis=0).max() < 100 * EPS * np.linalg.norm(M, axis=0).max()
    assert np.linalg.cond(M / np.linalg.norm(M, axis=0)) > 1e8  # so that the first line means something


def test_every_prefix_solves_its_own_least_squares_problem() -> None:
    M, b, forms = monomial_system(8)
    factor = BlockGramSchmidt(b, Policy(1e-13))
    for form in forms:
        factor.append(M[:, form])
        direct = np.linalg.lstsq(M[:, : form.stop], b)[0]
        condition = np.linalg.cond(M[:, : form.stop])
        np.testing.assert_allclose(factor.solve(), direct, atol=100 * EPS * condition * np.abs(direct).max())
        residual = M[:, : form.stop] @ direct - b
        assert abs(factor.rss - residual @ residual) <= 1e-12 * (b @ b)


def test_appending_changes_nothing_earlier() -> None:
    M, b, forms = monomial_system(6)
    low, high = factored(M, b, forms[:4]), factored(M, b, forms)
    k = len(low.rhs)
    np.testing.assert_array_equal(high.R[:k, :k], low.R)
    np.testing.assert_array_equal(high.rhs[:k], low.rhs)
    np.testing.assert_array_equal(np.tril(high.R, -1)[:, : forms[0].stop], 0.0)


def test_collinear_columns_are_left_out_and_the_fit_is_the_same() -> None:
    M, b, _ = monomial_system(4)
    generator = np.random.default_rng(3)
    dependent = M[:, :6] @ generator.normal(size=(6, 2))
    doubled = np.hstack([M[:, :8], dependent, M[:, 8:]])
    factor = factored(doubled, b, [slice(0, 6), slice(6, 11), slice(11, None)], 1e-12)
    assert np.flatnonzero(~factor.kept).tolist() == [8, 9]
    a = factor.solve()
    assert a[8] == 0.0
    assert a[9] == 0.0
    np.testing.assert_allclose(np.delete(a, [8, 9]), np.linalg.lstsq(M, b)[0], rtol=1e-9, atol=1e-10)


def test_collinearity_is_relative_to_the_columns_length() -> None:
    M, b, forms = monomial_system(5)
    tiny = M * np.logspace(0, -14, M.shape[1])  # small columns are no collinear columns
    assert factored(tiny, b, forms).kept.all()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_condition_is_close_to_the_true_one_and_does_not_depend_on_units(scale: float) -> None:
    M, b, forms = monomial_system(8)
    true = np.linalg.cond(M / np.linalg.norm(M, axis=0), 2)
    estimate = factored(M * scale ** np.arange(M.shape[1]), b, forms).condition()
    assert true / 3 < estimate < 30 * true  # 1-norm against 2-norm: a factor up to √m either way


def test_without_columns() -> None:
    factor = BlockGramSchmidt(np.ones(4), Policy(1e-10))
    assert factor.condition() == 1.0
    assert factor.rss == 4.0
    assert not factor.append(np.zeros((4, 2))).any()
    assert factor.solve().tolist() == [0.0, 0.0]
