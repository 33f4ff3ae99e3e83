import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.linear.qr.r_factor import RFactor

EPS = np.finfo(float).eps


def system(rows: int, columns: int) -> tuple[FloatArray, FloatArray]:
    generator = np.random.default_rng(0)
    return generator.normal(size=(rows, columns)), generator.normal(size=rows)


def of_rows(M: FloatArray, b: FloatArray, size: int) -> RFactor:
    starts = range(0, len(b), size)
    return RFactor.of_rows(M.shape[1], [(M[s : s + size].copy(order="F"), b[s : s + size]) for s in starts])


@pytest.mark.parametrize("size", [7, 100, 500])
def test_every_prefix_of_r_gives_the_least_squares_solution(size: int) -> None:
    M, b = system(500, 40)
    whole = of_rows(M, b, size)
    assert (whole.rows, whole.columns, whole.from_gram) == (500, 40, False)
    for k in (1, 13, 40):
        a = np.linalg.solve(whole.R[:k, :k], whole.rhs[:k])
        expected, rss, _, _ = np.linalg.lstsq(M[:, :k], b)
        np.testing.assert_allclose(a, expected, atol=100 * EPS)
        assert whole.residual_norm**2 + (whole.rhs[k:] ** 2).sum() == pytest.approx(rss[0], rel=1e-12)


def test_joined_factors_are_that_of_all_rows() -> None:
    M, b = system(300, 20)
    joined = of_rows(M[:120], b[:120], 50).joined(of_rows(M[120:], b[120:], 50))
    whole = of_rows(M, b, 300)
    np.testing.assert_allclose(np.abs(joined.R), np.abs(whole.R), atol=1e3 * EPS)
    assert joined.residual_norm == pytest.approx(whole.residual_norm, rel=1e-12)
    assert joined.rows == 300


def test_with_fewer_rows_than_columns_r_has_as_many_rows_that_are_not_zero() -> None:
    M, b = system(5, 8)
    few = of_rows(M, b, 2)
    np.testing.assert_allclose(few.R.T @ few.R, M.T @ M, atol=100 * EPS)
    assert few.residual_norm == pytest.approx(0.0, abs=100 * EPS)


def test_normal_equations_give_the_same_factor_up_to_the_square_of_the_condition() -> None:
    M, b = system(500, 40)
    M[:, 5] = M[:, 4] + 1e-5 * M[:, 5]  # condition 1e5
    squared, exact = RFactor.of_normal_equations(M.T @ M, M.T @ b, float(b @ b), 500), of_rows(M, b, 100)
    assert squared.from_gram
    a, expected = (np.linalg.solve(t.R, t.rhs) for t in (squared, exact))
    error = np.linalg.norm(M @ (a - expected))
    assert 100 * EPS < error < 1e5 * np.sqrt(EPS) * np.linalg.norm(b)
    assert squared.residual_norm == pytest.approx(exact.residual_norm, rel=1e-7)


def test_columns_that_cannot_be_factored_are_left_out_with_all_after_them() -> None:
    M, b = system(100, 10)
    M[:, 6] = M[:, :3].sum(axis=1)
    squared = RFactor.of_normal_equations(M.T @ M, M.T @ b, float(b @ b), 100)
    assert squared.columns in {6, 7, 8, 9}  # rounding decides where it ends, but never before
    k = 6
    a = np.linalg.solve(squared.R[:k, :k], squared.rhs[:k])
    np.testing.assert_allclose(a, np.linalg.lstsq(M[:, :k], b)[0], atol=1e4 * EPS)
