from collections.abc import Callable

import numpy as np
import pytest

import ipcore
from ipcore import FitOptions, shapes
from ipcore._typing import FloatArray
from ipcore.points.distinct import without_copies
from ipcore.shapes import Shape

OPTIONS = FitOptions(max_degree=8)


def repeated(points: FloatArray, how: str, times: int) -> FloatArray:
    """Return points, each so many times: one after the other, the whole set again and again, or in random order."""
    if how == "in turn":
        return np.repeat(points, times, axis=0)
    copies = np.tile(points, (times, 1))
    return copies if how == "again" else np.random.default_rng(0).permutation(copies)


def annulus() -> FloatArray:
    turn = 2.0 * np.pi * np.arange(120) / 120
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.vstack([2.0 * ring, ring[:60:2], ring[60::2]])


@pytest.mark.parametrize("how", ["in turn", "again", "mixed"])
@pytest.mark.parametrize("times", [2, 5])
@pytest.mark.parametrize("make", [shapes.ellipse, shapes.superellipse, shapes.sphere, shapes.torus])
def test_copies_with_normals_change_nothing(make: Callable[[], Shape], times: int, how: str) -> None:
    points, normals = make().sample(400)
    both = repeated(np.hstack([points, normals]), how, times)
    d = points.shape[1]
    once, many = ipcore.fit(points, normals, OPTIONS), ipcore.fit(both[:, :d], both[:, d:], OPTIONS)
    assert many.degree == once.degree
    assert many.stop_reason == once.stop_reason
    assert many.diagnostics.components == once.diagnostics.components
    assert many.diagnostics.merged == (times - 1) * len(points)
    assert [one.code for one in many.warnings] == ["copies-merged", *(one.code for one in once.warnings)]
    f, g = once.polynomial(points), many.polynomial(points)
    np.testing.assert_allclose(f, g, atol=1e-6)


@pytest.mark.parametrize("how", ["in turn", "again"])
@pytest.mark.parametrize("times", [2, 5])
def test_an_annulus_without_normals_stays_one(times: int, how: str) -> None:
    result = ipcore.fit(repeated(annulus(), how, times), options=OPTIONS)
    assert (result.degree, result.diagnostics.components) == (4, 2)
    assert result.diagnostics.d_dist < 1e-6
    assert result.diagnostics.normal_source == "outline"


def test_a_closed_outline_may_repeat_its_first_point() -> None:
    outline = annulus()[:120]
    result = ipcore.fit(np.vstack([outline, outline[:1]]), options=OPTIONS)
    assert result.degree == 2
    assert result.diagnostics.merged == 1


def test_copies_do_not_determine_coefficients() -> None:
    points = np.repeat(annulus()[:120:24], 10, axis=0)  # five points, which determine a conic
    result = ipcore.fit(points, options=FitOptions(t1=0.0, max_degree=4))
    assert max(step.degree for step in result.steps) == 2
    assert result.stop_reason == "too-few-points"
    with pytest.raises(ipcore.InvalidOptionsError, match="more than 5 points determine"):
        ipcore.fit_fixed(points, degree=3)


def test_copies_with_opposite_normals_are_kept() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]])
    normals = np.array([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [0.6, 0.8]])
    left, merged = without_copies(ipcore.check_points(points, normals))
    assert merged == 1
    np.testing.assert_array_equal(left.points, points[:4])
    assert left.normals is not None
    np.testing.assert_allclose(left.normals[[0, 3]], [[0.0, 1.0], [0.0, -1.0]])
    np.testing.assert_allclose(left.normals[1], [0.3, 0.9] / np.hypot(0.3, 0.9))


def test_zero_and_minus_zero_are_one_place() -> None:
    left, merged = without_copies(ipcore.check_points([[0.0, 0.0], [-0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    assert merged == 1
    assert len(left.points) == 3


def test_too_few_distinct_points_are_refused() -> None:
    with pytest.raises(ipcore.InvalidPointsError, match="only 3 of 30 points are distinct"):
        ipcore.fit(np.repeat(np.eye(3), 10, axis=0), np.repeat(np.eye(3), 10, axis=0))
