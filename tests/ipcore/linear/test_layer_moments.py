import numpy as np
import pytest

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.linear import layer_moments
from ipcore.linear.layer_moments import LayerMoments
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.univariate import Basis

EPS = np.finfo(float).eps
OFFSETS = (0.0, 0.05, -0.05)
SHAPES = {2: shapes.superellipse, 3: shapes.torus}


def data(d: int, count: int = 3000) -> tuple[FloatArray, FloatArray]:
    return SHAPES[d]().sample(count)


def rows(x: FloatArray, n: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """Return M and b, row by row."""
    at = np.concatenate([x + o * n for o in OFFSETS])
    tables = [univariate.table(Basis.MONOMIAL, column, degree) for column in at.T]
    M = graded.products(tables, graded.exponents(x.shape[1], degree)).T
    return M, np.repeat(OFFSETS, len(x))


@pytest.mark.parametrize(("d", "degree"), [(2, 7), (3, 5)])
def test_r_and_b_of_moments_are_those_of_the_rows(d: int, degree: int) -> None:
    x, n = data(d)
    t = LayerMoments.of(x, n, degree, OFFSETS).r_factor()
    M, b = rows(x, n, degree)
    size = np.linalg.norm(M, axis=0)
    np.testing.assert_allclose(t.R.T @ t.R / np.outer(size, size), M.T @ M / np.outer(size, size), atol=1e3 * EPS)
    np.testing.assert_allclose(t.R.T @ t.rhs / size, M.T @ b / size, atol=1e3 * EPS * np.linalg.norm(b))
    assert t.rows == len(b)
    assert t.residual_norm**2 + t.rhs @ t.rhs == pytest.approx(b @ b, rel=1e-12)


@pytest.mark.parametrize("d", [2, 3])
def test_moments_of_pieces_add_up(d: int) -> None:
    x, n = data(d, layer_moments.LAYER_CHUNK_POINTS + 1000)
    whole = LayerMoments.of(x, n, 6, OFFSETS)
    parts = [LayerMoments.of(x[s], n[s], 6, OFFSETS) for s in (slice(0, 10), slice(10, 4000), slice(4000, None))]
    total = LayerMoments.empty(d, 6, OFFSETS) + parts[0] + parts[1] + parts[2]
    assert total.count == whole.count == len(x)
    assert total.dimension == d
    np.testing.assert_allclose(total.sums, whole.sums, atol=EPS * len(x) * np.abs(x).max() ** 12)


@pytest.mark.parametrize(("d", "degree"), [(2, 7), (3, 5)])
def test_the_residuals_of_the_normal_equations_are_those_of_the_rows(d: int, degree: int) -> None:
    x, n = data(d)
    A = np.random.default_rng(0).normal(size=(graded.count(d, degree), 3))
    g, rss = layer_moments.normal_residuals(x, n, degree, OFFSETS, A)
    M, b = rows(x, n, degree)
    residuals = b[:, None] - M @ A
    np.testing.assert_allclose(g, M.T @ residuals, rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(rss, (residuals**2).sum(axis=0), rtol=1e-12)
