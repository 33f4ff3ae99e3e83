from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest

import ipcore
from ipcore import Constraints, FitOptions, shapes
from ipcore._typing import FloatArray
from ipcore.constraints import min_max, min_var
from ipcore.constraints.family import RowParameters
from ipcore.linear.dense import DenseFit
from ipcore.linear.design_matrix import DesignMatrix
from ipcore.points.oriented import OrientedPoints
from ipcore.points.validation import check
from ipcore.polynomial import graded
from ipcore.polynomial.univariate import Basis
from ipcore.shapes import Shape

EPS = np.finfo(float).eps
EVERY = [*shapes.CURVES, *shapes.SURFACES]
LINEAR = [family for family in Constraints if family is not Constraints.TAUBIN]
QUICK = FitOptions(measure_zero_set=False)


def oriented(make: Callable[[], Shape], count: int = 300) -> OrientedPoints:
    return OrientedPoints.of(check(*make().sample(count)), 12)


def coefficients_of(truth: Shape, fitted: ipcore.ImplicitPolynomial) -> FloatArray:
    """Return the shape's own coefficients in the frame of a fit, with the fit's norm."""
    lower, upper = truth.polynomial.bounds
    x = np.random.default_rng(0).uniform(lower, upper, (2000, fitted.dimension))
    u = fitted.frame.to_local(x)
    M = (u[:, None, :] ** fitted.exponents).prod(axis=2)
    a = np.linalg.lstsq(M, truth.polynomial(x))[0]
    return np.asarray(a * np.linalg.norm(fitted.coefficients) / np.linalg.norm(a))


@pytest.mark.parametrize("make", EVERY)
def test_taubin_finds_the_coefficients_of_noise_free_shapes(make: Callable[[], Shape]) -> None:
    shape = make()
    points, normals = shape.sample(300 if shape.polynomial.dimension == 2 else 1200)
    fitted = ipcore.fit_fixed(points, normals, QUICK, degree=shape.polynomial.degree, method="taubin").polynomial
    np.testing.assert_allclose(fitted.coefficients, coefficients_of(shape, fitted), atol=1e-8)


@pytest.mark.parametrize("make", [shapes.ellipse, shapes.superellipse, shapes.torus])
def test_layers_do_not_because_a_shapes_own_polynomial_is_not_constant_on_them(
    make: Callable[[], Shape],
) -> None:
    shape = make()
    degree = shape.polynomial.degree
    layered = ipcore.fit_fixed(*shape.sample(600), QUICK, degree=degree, method="3l").polynomial
    assert np.abs(layered.coefficients - coefficients_of(shape, layered)).max() > 1e-3
    # the shape's own polynomial is not ±c on the other two layers, whatever multiple of it is taken
    data = oriented(make)
    own = shape.polynomial(data.frame.to_raw(data.points + 0.05 * data.normals))
    assert own.std() > 0.01 * own.mean()


@pytest.mark.parametrize("family", Constraints)
def test_every_family_reproduces_a_plane(family: Constraints) -> None:
    generator = np.random.default_rng(0)
    rotation = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    normals = np.tile(rotation[0], (80, 1))
    x = generator.uniform(-1.0, 1.0, (80, 2)) @ rotation[1:] + 3.0
    plane = ipcore.fit_fixed(x, normals, QUICK, degree=1, method=family).polynomial
    assert np.abs(plane.distance(x)).max() < 1e-13
    assert (plane(x + 0.1 * normals) > 0.0).all()


@pytest.mark.parametrize("make", [shapes.circle, shapes.sphere])
def test_gradient_one_reproduces_circle_and_sphere(make: Callable[[], Shape]) -> None:
    points, normals = make().sample(600)  # (r² − 1)/2 is 0 there, with gradient n
    centred = np.vstack([points, -points])
    result = ipcore.fit_fixed(centred, np.vstack([normals, -normals]), QUICK, degree=2, method="gradient-one")
    assert result.diagnostics.distance_max < 1e-12


@pytest.mark.parametrize(
    ("family", "order"), [(Constraints.GRADIENT_ONE, 0), (Constraints.MIN_MAX, 1), (Constraints.MIN_VAR, 2)]
)
def test_a_fit_with_coefficients_to_spare_has_the_gradient_that_was_asked_for(family: Constraints, order: int) -> None:
    data = oriented(shapes.superellipse, 6)  # 18 equations for 28 coefficients, so all of them hold
    f = DenseFit(data, FitOptions(constraints=family), 6).raise_to(28).polynomial
    w = np.ones(6)
    if order:
        w = np.linalg.norm((data.points[:, None, :] ** graded.exponents(2, 6)).prod(axis=2), ord=order, axis=1)
    np.testing.assert_allclose(f(data.points), 0.0, atol=1e-10)
    np.testing.assert_allclose(f.gradient(data.points), (w / w.mean())[:, None] * data.normals, atol=1e-10)


@pytest.mark.parametrize(("module", "order"), [(min_max, 1), (min_var, 2)])
@pytest.mark.parametrize("make", [shapes.superellipse, shapes.torus])
def test_gradient_lengths_are_norms_of_all_monomials(module: ModuleType, order: int, make: Callable[[], Shape]) -> None:
    data = oriented(make)
    powers = graded.exponents(data.points.shape[1], 7)
    m = (data.points[:, None, :] ** powers).prod(axis=2)
    w = np.linalg.norm(m, ord=order, axis=1)
    np.testing.assert_allclose(module.gradient_length(data.points, 7), w / w.mean(), rtol=100 * EPS)


@pytest.mark.parametrize("family", LINEAR)
@pytest.mark.parametrize("make", [shapes.superellipse, shapes.torus])
def test_the_incremental_solve_is_the_direct_one(family: Constraints, make: Callable[[], Shape]) -> None:
    data, options = oriented(make), FitOptions(constraints=family)
    d = data.points.shape[1]
    rows = options.family.rows(data.points, data.normals, options.row_parameters)
    M = DesignMatrix(rows, Basis.CHEBYSHEV, data.bounds, 6).columns(0, graded.count(d, 6))
    fit = DenseFit(data, options, 6)
    for degree in (2, 5, 6):
        step = fit.raise_to(graded.count(d, degree))
        part, b = M[:, : step.columns], rows.b(degree)
        direct = np.linalg.lstsq(part, b)[0]
        tolerance = 1000 * EPS * step.condition * np.abs(direct).max()
        np.testing.assert_allclose(step.polynomial.coefficients, direct, atol=tolerance)
        assert step.rss == pytest.approx(float(((part @ direct - b) ** 2).sum()), rel=1e-9, abs=1e-20)


@pytest.mark.parametrize("kind", Basis)
@pytest.mark.parametrize("make", [shapes.superellipse, shapes.torus])
def test_rows_are_the_values_and_derivatives_that_they_state(kind: Basis, make: Callable[[], Shape]) -> None:
    data = oriented(make, 50)
    d, mu = data.points.shape[1], 0.3
    options = FitOptions(constraints=Constraints.THREE_LAYER_GRADIENT, gradient_weight=mu)
    rows = options.family.rows(data.points, data.normals, options.row_parameters)
    M = DesignMatrix(rows, kind, data.bounds, 5).columns(0, graded.count(d, 5))
    a: FloatArray = np.random.default_rng(1).normal(size=(M.shape[1],))
    f = data.polynomial(5, a, kind)
    expected = [f(data.points + o * data.normals) for o in (0.0, 0.05, -0.05)]
    expected += list(np.sqrt(mu) * f.gradient(data.points).T)
    np.testing.assert_allclose(M @ a, np.concatenate(expected), atol=1e-11)


def test_gradient_rows_along_axes_are_those_along_normal_and_tangents() -> None:
    data = oriented(shapes.superellipse)
    options = FitOptions(constraints=Constraints.GRADIENT_ONE)
    rows = options.family.rows(data.points, data.normals, options.row_parameters)
    M = DesignMatrix(rows, Basis.CHEBYSHEV, data.bounds, 6).columns(0, graded.count(2, 6))
    f, gx, gy = np.split(M, 3)
    n, w = data.normals, np.sqrt(options.gradient_weight)
    along, across = n[:, :1] * gx + n[:, 1:] * gy, -n[:, 1:] * gx + n[:, :1] * gy
    turned = np.vstack([f, along, across])
    b = np.concatenate([np.zeros(len(n)), np.full(len(n), w), np.zeros(len(n))])
    literature, ours = np.linalg.lstsq(turned, b)[0], np.linalg.lstsq(M, rows.b(6))[0]
    np.testing.assert_allclose(ours, literature, atol=1e-9 * np.abs(ours).max())


@pytest.mark.parametrize("family", Constraints)
def test_every_family_finds_a_degree_for_a_torus(family: Constraints) -> None:
    result = ipcore.fit(*shapes.torus().sample(1200), FitOptions(constraints=family, measure_zero_set=False))
    assert result.stop_reason is ipcore.StopReason.CRITERION_MET
    assert result.degree == 4


@pytest.mark.parametrize("family", [Constraints.FIVE_LAYER, Constraints.THREE_LAYER_GRADIENT, Constraints.GRADIENT_ONE])
def test_more_layers_or_gradient_rows_hold_the_gradient_at_high_degree(family: Constraints) -> None:
    # 120 points are few for degree 18: f turns between the three layers, and D_smooth falls
    angle = 2.0 * np.pi * np.arange(120) / 120
    radius = 1.0 + 0.25 * np.cos(3.0 * angle)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])

    def smooth(method: Constraints) -> float:
        # 190 coefficients, more than points: the search would stop there, the system itself has rows enough
        data = OrientedPoints.of(check(points), 12)
        step = DenseFit(data, FitOptions(constraints=method), 18).raise_to(graded.count(2, 18))
        gradient = step.polynomial.gradient(data.points)
        cosine = (gradient * data.normals).sum(axis=1) / np.linalg.norm(gradient, axis=1)
        return float(cosine.mean())

    assert smooth(Constraints.THREE_LAYER) < 0.9
    assert smooth(family) > 0.99


@pytest.mark.parametrize("family", Constraints)
@pytest.mark.parametrize("make", [shapes.superellipse, shapes.torus])
def test_the_attributes_of_a_family_are_true_of_its_rows(family: Constraints, make: Callable[[], Shape]) -> None:
    data = oriented(make, 40)
    d, rules = data.points.shape[1], family.family

    def system(distance: float, weight: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        rows = rules.rows(data.points, data.normals, RowParameters(distance, weight))
        M = DesignMatrix(rows, Basis.MONOMIAL, data.bounds, 3).columns(0, graded.count(d, 3))
        return M, rows.b(1), rows.b(3)

    M, b1, b3 = system(0.05, 0.3)
    assert len(M) == len(b1) == rules.rows_per_point(d) * len(data.points)
    assert rules.rhs_depends_on_degree is not np.array_equal(b1, b3)
    assert rules.uses_layer_distance is not np.array_equal(M, system(0.1, 0.3)[0])
    assert rules.uses_gradient_weight is not np.array_equal(M, system(0.05, 0.6)[0])
    assert rules.is_least_squares is bool(b1.any())


@pytest.mark.parametrize("family", Constraints)
def test_offsets_of_layers_are_all_that_a_layered_family_has(family: Constraints) -> None:
    data = oriented(shapes.torus, 20)
    rows = family.family.rows(data.points, data.normals, RowParameters(0.05, 0.3))
    layered = all(group.axis is None for group in rows.groups)
    offsets = family.family.layer_offsets(0.05)
    assert bool(offsets) is layered
    for offset, group in zip(offsets, rows.groups, strict=layered):
        np.testing.assert_array_equal(group.positions, data.points + offset * data.normals)
        np.testing.assert_array_equal(group.b, np.full(len(data.points), offset))
