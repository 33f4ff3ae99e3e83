"""Fits of singular, thin, repeated and small sets: no crash, no warning of numpy's, and true statements."""

import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ipcore
from ipcore import FitOptions, FitResult, StopReason
from ipcore._typing import FloatArray
from tests.ipcore.found_shapes import (
    CURVES,
    annulus,
    disc_in_disc,
    ellipsoid,
    lemniscate,
    needle,
    ring,
    three_discs,
    touching_discs,
    turned,
)  # fmt: skip

LOW = FitOptions(max_degree=6)


def checked_fit(points: FloatArray, normals: FloatArray | None = None, options: FitOptions = LOW) -> FitResult | None:
    """Fit, and check what is said of the answer on the answer itself; None if the points are refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            result = ipcore.fit(points, normals, options)
        except ipcore.IPCoreError:
            return None
    found, f = result.diagnostics, result.polynomial
    figures = [found.d_dist, found.d_smooth, found.distance_p95, found.distance_max, found.normal_self_check]
    assert np.isfinite([*figures, *f.coefficients]).all()
    assert (found.stray is None) == (not found.components)
    step = 3.0 * options.t1 * f.frame.scale
    near = covered(f, points, step)
    assert found.coverage is not None
    assert near.mean() >= found.coverage - 0.2  # which counts copies once, and looks in other directions
    if result.stop_reason is StopReason.CRITERION_MET:
        assert found.d_dist < options.t1 * (1.0 + 1e-9)
        assert found.coverage >= 0.9
        assert near.mean() >= 0.8
        assert found.components != 0
    return result


def covered(f: ipcore.ImplicitPolynomial, points: FloatArray, step: float) -> np.ndarray:
    """Return which points have both signs of f around them, on nested stars of directions."""
    directions = ring(16) if points.shape[1] == 2 else ellipsoid(40, (1.0, 1.0, 1.0))[0]
    values = [f(points)]
    for length in step * np.geomspace(1.0, 1e-6, 13):
        values += [f(points + length * direction) for direction in directions]
    return np.asarray((np.min(values, axis=0) <= 0.0) & (np.max(values, axis=0) >= 0.0))


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(
    name=st.sampled_from(sorted(CURVES)),
    count=st.sampled_from([12, 40, 120, 200]),
    ratio=st.sampled_from([1.0, 0.5, 0.3, 0.05, 0.01, 0.002]),
    angle=st.floats(0.0, 3.2),
    change=st.sampled_from(["none", "copies", "large", "small", "order"]),
)
def test_curves_as_people_have_them(name: str, count: int, ratio: float, angle: float, change: str) -> None:
    points = turned(CURVES[name](count, ratio), angle)
    changes = {
        "copies": np.tile(points, (3, 1)),
        "large": 1e6 * points,
        "small": 1e-6 * points,
        "order": np.random.default_rng(0).permutation(points),
    }
    checked_fit(changes.get(change, points))


@settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(
    axes=st.tuples(*[st.sampled_from([1.0, 0.3, 0.02, 0.002])] * 3),
    count=st.sampled_from([10, 60, 600]),
    seed=st.integers(0, 20),
    given_normals=st.booleans(),
)
def test_thin_bodies_as_people_have_them(
    axes: tuple[float, float, float], count: int, seed: int, *, given_normals: bool
) -> None:
    points, normals = ellipsoid(count, axes, seed)
    checked_fit(points, normals if given_normals else None, FitOptions(max_degree=3))


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(count=st.integers(3, 14), dimension=st.sampled_from([2, 3]), seed=st.integers(0, 50), grid=st.booleans())
def test_few_points(count: int, dimension: int, seed: int, *, grid: bool) -> None:
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (count, dimension))
    checked_fit(np.round(points) if grid else points)


@pytest.mark.parametrize("constraints", ["3l", "5l", "gradient-one", "min-max", "min-var", "taubin"])
@pytest.mark.parametrize("name", sorted(CURVES))
def test_linear_fits_of_them(name: str, constraints: str) -> None:
    options = FitOptions.of(constraints=constraints, geometric=False, max_degree=8)
    for ratio in (1.0, 0.3, 0.01):
        checked_fit(turned(CURVES[name](100, ratio), 0.3), options=options)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("ratio", [0.1, 0.01, 0.002])
def test_a_thin_ellipse_is_exact_however_it_lies(ratio: float, angle: float) -> None:
    result = checked_fit(turned(needle(200, ratio), angle))
    assert result is not None
    assert (result.degree, result.stop_reason) == (2, StopReason.CRITERION_MET)
    assert result.diagnostics.distance_max < 1e-6
    assert result.diagnostics.components == 1
    assert result.diagnostics.quiet
    assert result.polynomial(np.zeros((1, 2)))[0] < 0.0
    assert result.warnings == ()


@pytest.mark.parametrize("axes", [(50.0, 1.0, 1.0), (20.0, 20.0, 1.0), (50.0, 50.0, 1.0), (30.0, 6.0, 1.0)])
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_a_thin_ellipsoid_is_exact_however_it_lies(axes: tuple[float, float, float], seed: int | None) -> None:
    points, normals = ellipsoid(1200, axes, seed)
    result = checked_fit(points, normals, FitOptions(max_degree=4))
    assert result is not None
    assert (result.degree, result.stop_reason) == (2, StopReason.CRITERION_MET)
    assert result.diagnostics.distance_max < 1e-6
    assert result.diagnostics.components == 1
    assert result.diagnostics.normal_self_check > 0.95
    assert result.polynomial(np.zeros((1, 3)))[0] < 0.0


@pytest.mark.parametrize("angle", [0.0, 0.7])
@pytest.mark.parametrize(
    ("points", "degree"),
    [
        (touching_discs(100, 1.0), 4),
        (touching_discs(120, 0.4), 4),
        (disc_in_disc(120, 0.5), 4),
        (lemniscate(200, 1.0), 4),
        (three_discs(80, 1.0), 6),
        (annulus(120, 0.5), 4),
    ],
)
def test_curves_that_touch_or_cross_themselves_are_exact(points: FloatArray, degree: int, angle: float) -> None:
    result = checked_fit(turned(points, angle))
    assert result is not None
    assert (result.degree, result.stop_reason) == (degree, StopReason.CRITERION_MET)
    assert result.diagnostics.d_dist < 1e-4
    assert result.diagnostics.quiet


@pytest.mark.parametrize("points", [ring(5), turned(needle(5, 0.5), 0.3), ring(5, (100.0, 3.0), 1e-3)])
def test_five_points_determine_a_conic(points: FloatArray) -> None:
    result = checked_fit(points)
    assert result is not None
    assert result.degree == 2
    assert result.diagnostics.distance_max < 1e-3


@pytest.mark.parametrize(
    "points", [np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), turned(ring(4) * [2.0, 1.0], 0.4)]
)
def test_where_there_is_no_zero_set_that_is_said(points: FloatArray) -> None:
    result = checked_fit(points)
    assert result is not None
    assert result.stop_reason is StopReason.TOO_FEW_POINTS
    assert (result.diagnostics.components, result.diagnostics.stray, result.diagnostics.coverage) == (0, None, 0.0)
    assert [warning.code for warning in result.warnings] == ["too-few-points", "no-zero-set"]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("count", [100, 300, 1000])
@pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), (3.0, 2.0, 1.0), (1.0, 1.0, 0.4)])
def test_random_samples_of_closed_shapes_do_not_warn(axes: tuple[float, float, float], count: int, seed: int) -> None:
    u = np.random.default_rng(seed).normal(size=(count, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    normals = u / axes
    result = ipcore.fit(u * axes, normals, FitOptions(max_degree=4))
    assert result.degree == 2
    assert result.warnings == ()
    assert result.diagnostics.stray == 0.0
