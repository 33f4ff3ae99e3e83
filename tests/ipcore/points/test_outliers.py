from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import ipcore
from ipcore import FitOptions, shapes
from ipcore._typing import FloatArray
from ipcore.points.far_points import setting_the_unit
from ipcore.points.outliers import crowded, is_far, without_outliers
from ipcore.shapes import Shape

AWAY = np.array([100.0, 50.0])
ROBUST = FitOptions(robust=True, max_degree=6)


def circle(count: int = 200) -> FloatArray:
    turn = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([3.0 + 2.0 * np.cos(turn), 1.0 + 2.0 * np.sin(turn)])


def test_isolated_points_are_told_from_crowded_ones() -> None:
    points, _ = shapes.sphere().sample(1000)
    outliers = np.random.default_rng(0).uniform(1.5, 4.0, (50, 3))
    told = crowded(np.vstack([points, outliers]))
    assert told[:1000].all()
    assert not told[1000:].any()


@pytest.mark.parametrize("make", [*shapes.CURVES, *shapes.SURFACES])
def test_clean_shapes_have_no_outliers_and_no_points_that_set_the_unit(make: Callable[[], Shape]) -> None:
    points, _ = make().sample(500)
    assert not is_far(points).any()
    assert setting_the_unit(points) == 0


@pytest.mark.parametrize("size", [1, 2, 5, 12, 20])
@pytest.mark.parametrize("distance", [50.0, 1e3, 1e9])
def test_a_small_group_far_away_is_left_out_wherever_it_is(size: int, distance: float) -> None:
    rng = np.random.default_rng(size)
    far = max(distance, 1e3 if size > 8 else 0.0)  # a larger group may be a part of the shape, if it is not that far
    group = far * np.array([0.6, 0.8]) + 0.01 * rng.normal(size=(size, 2))
    told = is_far(np.vstack([circle(), group]))
    assert not told[:200].any()
    assert told[200:].all()


def test_two_shapes_far_from_each_other_are_both_kept() -> None:
    assert not is_far(np.vstack([circle(), circle() + 500.0])).any()


# a single far point; scanner rows of 0 beside a shape that is elsewhere; rows of -9999; several at once
ERRORS = [
    [[1e6, 0.0]],
    [[0.0, 0.0]] * 7,
    [[-9999.0, -9999.0]] * 20,
    [[1e6, 1e6], [-1e5, 3.0], [-9999.0, -9999.0]],
]


@pytest.mark.parametrize("far", ERRORS)
@pytest.mark.parametrize("at", ["first", "last", "between"])
def test_a_robust_fit_is_that_without_the_errors(far: list[list[float]], at: str) -> None:
    shape = circle() + AWAY
    cut = {"first": 0, "last": len(shape), "between": 77}[at]
    points = np.vstack([shape[:cut], far, shape[cut:]])
    robust, clean = ipcore.fit(points, options=ROBUST), ipcore.fit(shape, options=ROBUST)
    assert robust.degree == clean.degree == 2
    assert robust.polynomial.frame.scale == pytest.approx(clean.polynomial.frame.scale, rel=1e-2)
    assert robust.diagnostics.distance_max < 1e-6
    assert robust.diagnostics.components == 1
    distinct = len(np.unique(far, axis=0))
    assert robust.diagnostics.outliers == pytest.approx(distinct / (len(shape) + distinct))
    assert robust.diagnostics.normal_self_check > 0.95


@pytest.mark.parametrize("far", ERRORS)
def test_otherwise_a_warning_names_how_many_set_the_unit_and_what_helps(far: list[list[float]]) -> None:
    result = ipcore.fit(np.vstack([circle() + AWAY, far]), options=replace(ROBUST, robust=False))
    (warning,) = [one for one in result.warnings if one.code == "few-points-set-unit"]
    assert "robust=true" in warning.message
    distinct = len(np.unique(far, axis=0))
    assert warning.message.startswith("1 point was" if distinct == 1 else f"{distinct} points were")
    assert result.diagnostics.components != 0  # but None where the circle is too small for any grid


def test_of_too_few_points_none_is_left_out() -> None:
    given = ipcore.check_points([[0.0, 0.0], [1.0, 0.0], [500.0, 500.0]])
    left, count = without_outliers(given)
    assert count == 0
    assert left is given


@pytest.mark.parametrize("distance", [1e9, 1e100])
def test_a_point_beyond_rounding_is_named_where_the_others_look_like_one(distance: float) -> None:
    with pytest.raises(ipcore.InvalidPointsError, match="1 of them is so far from all others"):
        ipcore.fit(np.vstack([circle(), [[distance, 0.0]]]), options=ROBUST)


def test_a_group_of_some_percent_far_away_is_left_out() -> None:
    group = circle(12) + 1000.0
    robust = ipcore.fit(np.vstack([circle(), group]), options=ROBUST)
    assert robust.degree == 2
    assert robust.polynomial.frame.scale == pytest.approx(2.0, rel=1e-2)
    plain = ipcore.fit(np.vstack([circle(), group]), options=replace(ROBUST, robust=False))
    assert "few-points-set-unit" in [warning.code for warning in plain.warnings]


@pytest.mark.parametrize("seed", range(4))
def test_inward_is_said_of_given_normals_only(seed: int) -> None:
    u = np.random.default_rng(seed).normal(size=(300, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    result = ipcore.fit(np.vstack([u, [[1e6, 0.0, 0.0]]]), options=FitOptions(max_degree=2))
    codes = [warning.code for warning in result.warnings]
    assert "few-points-set-unit" in codes
    assert "normals-inward" not in codes
