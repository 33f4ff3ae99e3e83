from collections.abc import Callable

import numpy as np
import pytest
from skimage import data, measure

import ipcore
from ipcore import FitOptions, shapes
from ipcore._typing import FloatArray
from ipcore.search.result import FitResult
from ipcore.shapes import Shape

EPS = np.finfo(float).eps


def horse() -> FloatArray:
    return np.asarray(max(measure.find_contours((~data.horse()).astype(float), 0.5), key=len))[::3]


def star(count: int = 400) -> tuple[FloatArray, FloatArray]:
    """Return a star of five rounded arms, one of them longer, r = 1 + 0.35 cos 5θ + 0.15 cos θ, and its normals."""
    turn = 2.0 * np.pi * np.arange(count) / count
    r = 1.0 + 0.35 * np.cos(5.0 * turn) + 0.15 * np.cos(turn)
    slope = -1.75 * np.sin(5.0 * turn) - 0.15 * np.sin(turn)
    out, along = np.column_stack([np.cos(turn), np.sin(turn)]), np.column_stack([-np.sin(turn), np.cos(turn)])
    tangent = slope[:, None] * out + r[:, None] * along
    normals = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    return r[:, None] * out, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def good(result: FitResult, stray: float = 0.0) -> bool:
    found = result.diagnostics
    close = found.d_dist < 0.01 and found.d_smooth > 0.95
    return close and found.components == 1 and found.stray is not None and found.stray <= stray


@pytest.mark.parametrize("make", [*shapes.CURVES, *shapes.SURFACES])
def test_known_shapes_are_fitted_well_at_no_higher_degree(make: Callable[[], Shape]) -> None:
    shape = make()
    points, normals = shape.sample(300 if shape.polynomial.dimension == 2 else 1500)
    result = ipcore.fit(points, normals)
    true = ipcore.zero_set(shape.polynomial, data=points, restrict=False, cap=False).stray  # in gaps of the sample
    assert true is not None
    assert good(result, stray=true + 0.01)
    assert result.diagnostics.quiet
    assert result.degree <= shape.polynomial.degree
    assert result.stop_reason is ipcore.StopReason.CRITERION_MET
    if result.degree == shape.polynomial.degree:
        assert result.diagnostics.distance_max < 1e-3


def test_a_star_needs_a_lower_degree_than_its_linear_fit_which_is_not_quiet() -> None:
    points, normals = star()
    quiet, plain = ipcore.fit(points, normals), ipcore.fit(points, normals, FitOptions(geometric=False))
    assert good(quiet)
    assert not good(plain)
    assert quiet.degree < plain.degree


def test_a_horse_comes_whole_and_alone() -> None:
    result = ipcore.fit(horse())
    assert good(result)
    assert result.degree <= 18
    low = ipcore.fit(horse(), options=FitOptions(max_degree=8))
    assert low.stop_reason is ipcore.StopReason.MAX_DEGREE
    assert low.degree == 8
    assert low.diagnostics.stray is not None
    assert low.diagnostics.stray < 0.01


def test_the_same_points_get_the_same_fit() -> None:
    points, normals = star()
    one, other = ipcore.fit(points, normals), ipcore.fit(points, normals)
    np.testing.assert_array_equal(one.polynomial.coefficients, other.polynomial.coefficients)


def test_neither_place_nor_size_nor_order_of_axes_matters() -> None:
    points, normals = star()
    plain = ipcore.fit(points, normals)
    x = points + 0.02 * normals
    expected = plain.polynomial(x)
    mirror, swap = np.diag([-1.0, 1.0]), np.array([[0.0, 1.0], [1.0, 0.0]])
    for size, place, turn in ((37.0, 1000.0, np.eye(2)), (1.0, 0.0, swap), (1.0, 0.0, mirror)):
        moved = ipcore.fit(size * points @ turn + place, normals @ turn)
        assert moved.degree == plain.degree
        # rounding is amplified on the way down: by the condition, and where a step is taken or not
        found = moved.polynomial(size * x @ turn + place)
        np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


def test_a_fixed_degree_is_fitted_the_same_way() -> None:
    points, normals = star()
    searched = ipcore.fit(points, normals)
    fixed = ipcore.fit_fixed(points, normals, degree=searched.degree)
    assert fixed.degree == searched.degree
    assert fixed.diagnostics.quiet
    assert fixed.diagnostics.d_dist < 0.011
    assert len(fixed.steps) == 1


@pytest.mark.parametrize(("signs", "geometric"), [(True, False), (False, True)])
def test_each_half_can_be_had_alone(signs: bool, geometric: bool) -> None:
    points, normals = star()
    result = ipcore.fit(points, normals, FitOptions(signs=signs, geometric=geometric))
    assert result.stop_reason is ipcore.StopReason.CRITERION_MET
    assert result.diagnostics.quiet is (True if signs else None)
    assert result.steps[-1].quiet is (True if signs else None)
    assert result.steps[-1].iterations > 0


def test_parts_that_do_not_belong_together_stay_apart() -> None:
    turn = 2.0 * np.pi * np.arange(150) / 150
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    points, normals = np.vstack([circle, circle + np.array([3.0, 0.0])]), np.vstack([circle, circle])
    result = ipcore.fit(points, normals)
    assert result.stop_reason is ipcore.StopReason.CRITERION_MET
    assert result.diagnostics.components == 2
    assert result.diagnostics.stray == 0.0


def test_a_hole_stays_open() -> None:
    points, normals = shapes.torus().sample(2000)
    result = ipcore.fit(points, normals)
    assert float(result.polynomial(np.zeros((1, 3)))[0]) > 0.0
    assert result.diagnostics.components == 1


def test_a_robust_fit_survives_outliers_and_says_so() -> None:
    points, normals = star()
    generator = np.random.default_rng(0)
    wild = generator.uniform(-1.6, 1.6, (20, 2))
    turned = generator.normal(size=(20, 2))
    mixed = np.vstack([points, wild]), np.vstack([normals, turned])
    robust = ipcore.fit(*mixed, FitOptions(robust=True))
    assert robust.stop_reason is ipcore.StopReason.CRITERION_MET
    assert float(np.abs(robust.polynomial.distance(points)).mean()) < 0.012
    assert robust.diagnostics.components == 1
    assert robust.diagnostics.outliers is not None
    assert 0.02 < robust.diagnostics.outliers < 0.08
    assert any("outliers" in warning.message for warning in robust.warnings)
    assert ipcore.fit(*mixed, FitOptions(max_degree=robust.degree)).stop_reason is ipcore.StopReason.MAX_DEGREE


def test_an_open_scan_says_where_it_does_not_know() -> None:
    points, normals = shapes.sphere().sample(3000)
    half = points[:, 2] > 0.3
    result = ipcore.fit(points[half], normals[half])
    assert result.diagnostics.d_dist < 0.01
    assert result.diagnostics.unsure is not None
    assert result.diagnostics.unsure > 0.05
    assert any("do not tell inside from outside" in warning.message for warning in result.warnings)
    whole = ipcore.fit(points, normals).diagnostics
    assert whole.unsure is not None
    assert whole.unsure < 0.01
