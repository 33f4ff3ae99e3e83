from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import ipcore
from ipcore import Factor, FitOptions, RidgeMatrix, shapes
from ipcore._typing import FloatArray
from ipcore.linear import ridge
from ipcore.linear.dense import DenseFit
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.linear.qr.gram_schmidt import GramSchmidt
from ipcore.options.choices import Collinear
from ipcore.points.oriented import OrientedPoints
from ipcore.points.validation import check
from ipcore.polynomial import graded, univariate
from ipcore.polynomial.univariate import Basis

EPS = np.finfo(float).eps
KINDS: list[Any] = [BlockGramSchmidt, GramSchmidt]
FULL = Policy(1e-12, Collinear.DROP, full=True)


def system(degree: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return M, b and D of points near an ellipse."""
    generator = np.random.default_rng(0)
    angle, radius = generator.uniform(0.0, 2.0 * np.pi, 600), generator.uniform(0.9, 1.1, 600)
    x = np.column_stack([radius * np.cos(angle), 0.7 * radius * np.sin(angle)])
    tables = [univariate.table(Basis.MONOMIAL, row.copy(), degree) for row in x.T]
    M = graded.products(tables, graded.exponents(2, degree)).T
    return M, np.cos(3.0 * x[:, 0]) - x[:, 1], ridge.diagonal(RidgeMatrix.INVARIANT, x, degree)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("kappa", [1e-6, 1e-3, 1.0])
def test_it_solves_equation_8(kind: Any, kappa: float) -> None:  # noqa: ANN401 - either class
    M, b, D = system(5)
    factor = kind(b, FULL, M.shape[1])
    factor.append(M, kappa * D)
    a = factor.solve()
    np.testing.assert_allclose((M.T @ M + kappa * np.diag(D)) @ a, M.T @ b, atol=1e-10 * np.abs(M.T @ b).max())
    # as printed, with R and b̃ of M alone: (R + κ R⁻ᵀ D) a = b̃
    plain = kind(b, Policy(1e-12))
    plain.append(M)
    printed = plain.R + kappa * np.linalg.solve(plain.R.T, np.diag(D))
    np.testing.assert_allclose(printed @ a, plain.rhs, atol=1e-8 * float(np.linalg.norm(b)))
    assert factor.rss == pytest.approx(float(((M @ a - b) ** 2).sum()), rel=1e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_appending_moves_nothing_earlier_and_adds_to_the_diagonal(kind: Any) -> None:  # noqa: ANN401 - either class
    M, b, D = system(4)
    kappa, k = 1e-2, M.shape[1]
    factor = kind(b, FULL, k)
    factor.append(M[:, : k - 1], kappa * D[: k - 1])
    before = factor.R.copy(), factor.rhs.copy()
    factor.append(M[:, k - 1 :], kappa * D[k - 1 :])
    np.testing.assert_array_equal(factor.R[: k - 1, : k - 1], before[0])
    np.testing.assert_array_equal(factor.rhs[: k - 1], before[1])
    undamped = kind(b, FULL, k)
    undamped.append(M[:, : k - 1], kappa * D[: k - 1])
    undamped.append(M[:, k - 1 :], np.zeros(1))
    assert abs(factor.R[-1, -1]) == pytest.approx(np.hypot(undamped.R[-1, -1], np.sqrt(kappa * D[-1])), rel=1e-12)


@pytest.mark.parametrize("ridged", ["full", "selective"])
@pytest.mark.parametrize("factor", [Factor.BLOCK, Factor.GRAM_SCHMIDT])
def test_the_prefix_of_degree_8_is_the_fit_of_degree_8(ridged: str, factor: Factor) -> None:
    data = OrientedPoints.of(check(*shapes.superellipse().sample(300)), 12)
    options = FitOptions.of(ridge=ridged, factor=factor, collinear_tol=1e-3)
    eight, twelve = DenseFit(data, options, 8), DenseFit(data, options, 12)
    alone = eight.raise_to(graded.count(2, 8))
    first = twelve.raise_to(graded.count(2, 8))
    last = twelve.raise_to(graded.count(2, 12))
    assert last.ridged > first.ridged > 0
    tolerance = 100 * EPS * alone.condition  # the two only sum over vectors of different length
    np.testing.assert_allclose(first.polynomial.coefficients, alone.polynomial.coefficients, atol=tolerance)
    straight = DenseFit(data, options, 12).raise_to(graded.count(2, 12))
    np.testing.assert_array_equal(last.polynomial.coefficients, straight.polynomial.coefficients)


@pytest.mark.parametrize("dimension", [2, 3])
def test_d_is_what_no_rotation_changes(dimension: int) -> None:
    generator = np.random.default_rng(2)
    x = generator.normal(size=(300, dimension))
    rotation = np.linalg.qr(generator.normal(size=(dimension, dimension)))[0]
    powers = graded.exponents(dimension, 5)
    a = generator.normal(size=len(powers))
    M, N = ((y[:, None, :] ** powers).prod(axis=2) for y in (x, x @ rotation))
    turned = np.linalg.lstsq(N, M @ a)[0]
    D = ridge.diagonal(RidgeMatrix.INVARIANT, x, 5)
    assert float(D @ turned**2) == pytest.approx(float(D @ a**2), rel=1e-9)
    assert abs(turned @ turned - a @ a) > 0.01 * (a @ a)


@pytest.mark.parametrize(("matrix", "same"), [("invariant", True), ("identity", False)])
def test_a_turned_shape_has_the_same_ridged_fit_with_the_appendixs_d_alone(matrix: str, *, same: bool) -> None:
    points, normals = shapes.superellipse().sample(300)
    rotation = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    options = FitOptions.of(ridge="full", ridge_matrix=matrix, ridge_strength=1e-1, measure_zero_set=False)
    plain = ipcore.fit_fixed(points, normals, options, degree=6).steps[0]
    turned = ipcore.fit_fixed(points @ rotation.T, normals @ rotation.T, options, degree=6).steps[0]
    assert (abs(plain.d_dist - turned.d_dist) < 1e-11) == same


def test_more_damping_is_less_condition_less_freedom_and_more_residual() -> None:
    points, normals = shapes.superellipse().sample(300)
    steps = []
    for kappa in (1e-12, 1e-8, 1e-4, 1e-1):
        options = FitOptions.of(ridge="full", ridge_strength=kappa, measure_zero_set=False)
        steps.append(ipcore.fit_fixed(points, normals, options, degree=10).steps[0])
    for less, more in pairwise(steps):
        assert more.condition < less.condition
        assert more.rss > less.rss
        assert more.ridged == more.columns == 66


def test_degrees_of_freedom_are_the_trace_of_the_hat_matrix() -> None:
    M, b, D = system(5)
    factor = BlockGramSchmidt(b, FULL, M.shape[1])
    factor.append(M[:, :6], D[:6])
    factor.append(M[:, 6:], D[6:])
    hat = M @ np.linalg.solve(M.T @ M + np.diag(D), M.T)
    assert factor.degrees_of_freedom == pytest.approx(float(np.trace(hat)), rel=1e-9)


def test_selective_damping_touches_only_collinear_columns() -> None:
    points, normals = shapes.superellipse().sample(300)
    options = FitOptions.of(ridge="selective", collinear_tol=1e-2, measure_zero_set=False)
    selective = ipcore.fit_fixed(points, normals, options, degree=10).steps[0]
    dropped = ipcore.fit_fixed(
        points, normals, FitOptions.of(collinear_tol=1e-2, factor="gram-schmidt", measure_zero_set=False), degree=10
    ).steps[0]
    assert selective.dropped == 0
    assert 0 < selective.ridged < selective.columns
    assert selective.ridged == pytest.approx(dropped.dropped, abs=2)
