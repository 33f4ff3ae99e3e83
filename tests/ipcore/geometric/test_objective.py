import numpy as np
import pytest

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.levenberg_marquardt import Effort, refine
from ipcore.geometric.objective import DataTables, Objective
from ipcore.geometric.sign_constraints import SignNodes, SignPoints
from ipcore.polynomial import evaluation, graded

EPS = np.finfo(float).eps
MADE = {2: shapes.ellipse, 3: shapes.torus}
ANGLE = 0.01


def objective(d: int, degree: int, blend: float) -> tuple[Objective, FloatArray, FloatArray]:
    """Return an objective with both kinds of sign constraints and uneven weights, its points and normals."""
    shape = MADE[d]()
    points, normals = shape.sample(300)
    bounds = shape.polynomial.bounds
    generator = np.random.default_rng(3)
    data = DataTables(points, normals, generator.uniform(0.5, 1.5, 300), bounds)
    nodes = SignNodes.of(InsideOutside(points, normals, bounds), bounds, 13, 10.0)
    t = generator.uniform(-1.0, 1.0, (40, d))
    places = SignPoints(t, np.where(t[:, 0] > 0.0, 1.0, -1.0), np.full(40, 0.05), generator.uniform(0.1, 1.0, 40))
    return Objective(data, degree, [nodes, places], ANGLE, blend), points, normals


@pytest.mark.parametrize("blend", [0.0, 0.7, 1.0])
@pytest.mark.parametrize("d", [2, 3])
def test_the_gradient_is_that_of_finite_differences(d: int, blend: float) -> None:
    phi, _, _ = objective(d, 4, blend)
    generator = np.random.default_rng(1)
    a, e, h = generator.normal(size=phi.columns), generator.normal(size=phi.columns), 1e-5
    r = phi.normal_equations(phi.evaluate(a))[1]
    slope = (phi.evaluate(a + h * e).value - phi.evaluate(a - h * e).value) / (2.0 * h)
    # φ and its derivatives are of the size of φ / ‖a‖; second differences leave h², and the hinge's kink a share of h
    assert slope == pytest.approx(-2.0 * r @ e, abs=1e-4 * (abs(slope) + phi.evaluate(a).value))


@pytest.mark.parametrize("d", [2, 3])
def test_the_gauss_newton_matrix_from_moments_is_that_of_the_jacobian(d: int) -> None:
    phi, points, _ = objective(d, 3, 1.0)
    phi.signs = []
    a = np.random.default_rng(1).normal(size=phi.columns)
    evaluation, w, h = phi.evaluate(a), np.sqrt(phi.data.weights), 1e-6
    columns = []
    for e in np.eye(phi.columns):
        ahead, behind = phi.evaluate(a + h * e), phi.evaluate(a - h * e)
        bent = (ahead.direction - behind.direction) * np.sqrt(ANGLE)
        both = np.vstack([ahead.distance - behind.distance, bent]) * w
        columns.append(both.ravel() / (2.0 * h))
    J = np.stack(columns, axis=1)
    H = phi.normal_equations(evaluation)[0]
    assert len(J) == (1 + d) * len(points)
    np.testing.assert_allclose(H, J.T @ J, atol=1e-5 * np.abs(H).max())
    np.testing.assert_allclose(H, H.T, atol=64.0 * EPS * np.abs(H).max())


@pytest.mark.parametrize("d", [2, 3])
def test_the_datas_part_of_the_matrix_is_kept_for_some_steps(d: int) -> None:
    phi, _, _ = objective(d, 3, 1.0)
    fresh, _, _ = objective(d, 3, 1.0)
    phi.keep_data_matrix(3)
    generator = np.random.default_rng(1)
    places = [generator.normal(size=phi.columns) for _ in range(4)]
    signs = [*phi.signs]
    fresh.signs = []
    first = fresh.normal_equations(fresh.evaluate(places[0]))[0]
    for number, a in enumerate(places):
        H, r = phi.normal_equations(phi.evaluate(a))
        fresh.signs = signs
        exact, gradient = fresh.normal_equations(fresh.evaluate(a))
        np.testing.assert_array_equal(r, gradient)
        fresh.signs = []
        data = fresh.normal_equations(fresh.evaluate(a))[0]
        expected = exact - data + (first if number < 3 else data)
        np.testing.assert_allclose(H, expected, atol=1e-12 * np.abs(H).max())


@pytest.mark.parametrize("change", ["blend", "angle_weight", "data", "keep"])
def test_what_is_kept_is_of_the_same_objective(change: str) -> None:
    phi, points, normals = objective(3, 3, 1.0)
    phi.keep_data_matrix(10)
    a, b = np.random.default_rng(1).normal(size=(2, phi.columns))
    phi.normal_equations(phi.evaluate(a))
    if change == "data":
        bounds = shapes.torus().polynomial.bounds
        phi.data = DataTables(points[:200], normals[:200], np.ones(200), bounds)
    elif change == "keep":
        phi.keep_data_matrix(10)
    else:
        setattr(phi, change, 0.5)
    H = phi.normal_equations(phi.evaluate(b))[0]
    other = Objective(phi.data, 3, phi.signs, phi.angle_weight, phi.blend)
    np.testing.assert_allclose(H, other.normal_equations(other.evaluate(b))[0], atol=1e-12 * np.abs(H).max())


@pytest.mark.parametrize("d", [2, 3])
def test_scaling_f_changes_neither_closeness_nor_the_first_two_terms(d: int) -> None:
    phi, _, _ = objective(d, 3, 1.0)
    phi.signs = []
    a = np.random.default_rng(1).normal(size=phi.columns)
    one, other = phi.evaluate(a), phi.evaluate(7.0 * a)
    assert other.value == pytest.approx(one.value, rel=1e-12)
    assert phi.closeness(other) == pytest.approx(phi.closeness(one), rel=1e-12)


@pytest.mark.parametrize("d", [2, 3])
def test_at_blend_zero_the_objective_is_convex(d: int) -> None:
    phi, _, _ = objective(d, 4, 0.0)
    generator = np.random.default_rng(2)
    for _ in range(20):
        a, b = generator.normal(size=(2, phi.columns))
        ends = phi.evaluate(a).value + phi.evaluate(b).value
        assert phi.evaluate((a + b) / 2.0).value <= ends / 2.0 * (1.0 + 8.0 * EPS)


@pytest.mark.parametrize("d", [2, 3])
def test_refining_goes_down_to_an_exact_shape(d: int) -> None:
    shape = MADE[d]()
    phi, _, _ = objective(d, shape.polynomial.degree, 0.0)
    phi.signs = phi.signs[:1]
    start = refine(phi, np.zeros(phi.columns), Effort(8, 1e-2, 1)).coefficients
    phi.blend = 1.0
    before, fit = phi.evaluate(start).value, refine(phi, start, Effort(60, 1e-6, 3))
    assert fit.evaluation.value < 1e-3 * before
    d_dist, d_smooth = phi.closeness(fit.evaluation)
    assert d_dist < 1e-3
    assert d_smooth > 0.999
    assert graded.count(d, shape.polynomial.degree) == len(fit.coefficients)


def test_a_sign_that_is_asked_for_is_had() -> None:
    phi, _, _ = objective(2, 4, 0.0)
    nodes = phi.signs[0]
    far = SignPoints(np.zeros((1, 2)), np.ones(1), np.full(1, 0.1), np.full(1, 1e3))  # outside, in the very middle
    phi.signs = [nodes]
    inside = refine(phi, np.zeros(phi.columns), Effort(20, 1e-6, 2))
    phi.signs = [nodes, far]
    forced = refine(phi, inside.coefficients, Effort(40, 1e-6, 2))
    assert inside.evaluation.shortfalls[0].max() < 0.1
    assert far.shortfall(tensor(phi, inside.coefficients))[0] > 0.1
    assert far.shortfall(tensor(phi, forced.coefficients))[0] < 0.01


def tensor(phi: Objective, a: FloatArray) -> FloatArray:
    return evaluation.to_tensor(a, phi.data.dimension, phi.degree)
