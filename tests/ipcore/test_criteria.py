import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcore import shapes
from ipcore.criteria import Closeness, StoppingRule

RULE = StoppingRule(0.01, 0.95)


def test_points_beside_a_circle_are_as_far_as_they_are() -> None:
    points, normals = shapes.circle().sample(100)
    circle = shapes.circle().polynomial
    at = Closeness.of(*circle.value_and_gradient(points + 1e-4 * normals), normals)
    assert abs(at.d_dist - 1e-4) < 1e-7  # first order: the error is of second
    assert abs(at.d_smooth - 1.0) < 1e-12
    assert abs(Closeness.of(*circle.value_and_gradient(points), -normals).d_smooth + 1.0) < 1e-12


def test_a_point_without_gradient_is_far_and_not_undefined() -> None:
    at = Closeness.of(np.array([1.0]), np.zeros((1, 2)), np.array([[1.0, 0.0]]))
    assert at.d_dist > 1e300
    assert at.d_smooth == 0.0


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
