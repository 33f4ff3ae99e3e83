import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.search.criteria import Leverage, StoppingRule, bic, distances_and_cosines, gcv

RULE = StoppingRule(0.01, 0.95)


def test_points_beside_a_circle_are_as_far_as_they_are() -> None:
    points, normals = shapes.circle().sample(100)
    circle = shapes.circle().polynomial
    distances, cosines = distances_and_cosines(*circle.value_and_gradient(points + 1e-4 * normals), normals)
    assert np.abs(distances - 1e-4).max() < 1e-7  # first order: the error is of second
    assert np.abs(cosines - 1.0).max() < 1e-12
    _, inward = distances_and_cosines(*circle.value_and_gradient(points), -normals)
    assert np.abs(inward + 1.0).max() < 1e-12


def test_a_point_without_gradient_is_far_and_not_undefined() -> None:
    (distance,), (cosine,) = distances_and_cosines(np.array([1.0]), np.zeros((1, 2)), np.array([[1.0, 0.0]]))
    assert distance > 1e300
    assert cosine == 0.0


@pytest.mark.parametrize(
    ("d_dist", "d_smooth", "met"),
    [(0.009, 0.96, True), (0.01, 0.96, False), (0.009, 0.95, False), (float("nan"), 0.96, False)],
)
def test_rule_is_equation_7(d_dist: float, d_smooth: float, *, met: bool) -> None:
    assert RULE.met(d_dist, d_smooth) is met


@given(st.floats(0.0, 1.0), st.floats(-1.0, 1.0))
def test_excess_is_below_one_exactly_when_the_rule_is_met(d_dist: float, d_smooth: float) -> None:
    excess = RULE.excess(d_dist, d_smooth)
    if abs(excess - 1.0) > 1e-12:  # at the edge itself rounding decides
        assert (excess < 1.0) == RULE.met(d_dist, d_smooth)


def least_squares(count: int, groups: int, columns: int) -> tuple[FloatArray, FloatArray]:
    generator = np.random.default_rng(4)
    return generator.normal(size=(groups * count, columns)), generator.normal(size=groups * count)


@pytest.mark.parametrize("groups", [1, 3])
@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_leaving_points_out_is_fitting_without_all_their_rows(groups: int, damping: float) -> None:
    count, columns = 40, 9
    M, b = least_squares(count, groups, columns)
    policy = Policy(1e-12, full=damping > 0.0)
    factor = BlockGramSchmidt(b, policy, columns if damping else 0)
    leverage = Leverage(groups, count)
    for part in (slice(0, 4), slice(4, columns)):
        factor.append(M[:, part], np.full(part.stop - part.start, damping))
        leverage.add(factor.data_blocks(leverage.columns))
    errors = []
    for point in range(count):  # the definition: fit without the point's rows, and predict them
        rows = np.arange(groups) * count + point
        rest = np.delete(np.arange(groups * count), rows)
        a = np.linalg.solve(M[rest].T @ M[rest] + damping * np.eye(columns), M[rest].T @ b[rest])
        errors.append((M[rows] @ a - b[rows]) ** 2)
    assert leverage.left_out(factor.residual) == pytest.approx(float(np.mean(errors)), rel=1e-9)


def test_a_point_that_alone_determines_a_coefficient_cannot_be_left_out() -> None:
    leverage = Leverage(1, 2)
    leverage.add([np.eye(2)])
    assert leverage.left_out(np.zeros(2)) == float("inf")


def test_generalised_cross_validation_is_leave_one_out_with_every_leverage_alike() -> None:
    M = np.exp(2j * np.pi * np.outer(np.arange(12), np.arange(1, 3)) / 12).view(float)  # a tight frame: H_ii = 4/12
    b = np.random.default_rng(1).normal(size=12)
    factor, leverage = BlockGramSchmidt(b, Policy(1e-12)), Leverage(1, 12)
    factor.append(M)
    leverage.add(factor.data_blocks())
    assert gcv(12, factor.freedom, factor.rss) == pytest.approx(leverage.left_out(factor.residual), rel=1e-12)
    assert gcv(4, 4.0, 0.0) == float("inf")


def test_bic_is_minus_twice_the_log_likelihood_plus_k_log_n() -> None:
    rows, k, rss = 50, 7.0, 2.5
    variance = rss / rows  # Gaussian errors of this variance, the constant n(1 + ln 2π) left out
    log_likelihood = -rows / 2 * (np.log(2 * np.pi * variance) + 1.0)
    expected = -2.0 * log_likelihood - rows * (1.0 + np.log(2 * np.pi)) + k * np.log(rows)
    assert bic(rows, k, rss) == pytest.approx(float(expected), rel=1e-12)
    assert np.isfinite(bic(rows, k, 0.0))
