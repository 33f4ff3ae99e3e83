from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

import ipcore
from ipcore import FitOptions, Moments, shapes
from ipcore._typing import FloatArray
from ipcore.errors import InvalidOptionsError, InvalidPointsError

OPTIONS = FitOptions.of(factor="moments", max_degree=8, measure_zero_set=False)


def rough(count: int = 6000) -> tuple[FloatArray, FloatArray]:
    points, normals = shapes.genus_two().sample(count)
    moved = points + np.random.default_rng(0).normal(scale=0.01, size=points.shape)
    return 37.0 * moved + [1000.0, -5.0, 3.0], normals


def test_moments_give_the_fit_of_the_points() -> None:
    points, normals = rough()
    whole = ipcore.fit(points, normals, OPTIONS)
    alone = Moments.of(points, 2.0 * normals, degree=8).fit(OPTIONS)
    assert (alone.degree, alone.stop_reason) == (whole.degree, whole.stop_reason)
    np.testing.assert_allclose(alone.polynomial(points), whole.polynomial(points), atol=1e-9)
    assert alone.diagnostics.d_dist == pytest.approx(whole.diagnostics.d_dist, rel=1e-9)  # the sample is all of them


def test_merged_and_extended_moments_equal_those_of_the_whole() -> None:
    points, normals = rough()
    whole = Moments.of(points, normals, degree=6)
    a, b, c = ((points[s], normals[s]) for s in (slice(0, 1000), slice(1000, 2500), slice(2500, None)))
    first, second, third = (Moments.of(*part, degree=6, frame=whole.frame) for part in (a, b, c))
    for merged in (first + second + third, third + first + second, first.extended(*b).extended(*c)):
        assert merged.count == whole.count
        np.testing.assert_array_equal(merged.box, whole.box)
        np.testing.assert_array_equal(merged.sample.points, whole.sample.points)
        scale = np.abs(whole.layers.sums).max()
        np.testing.assert_allclose(merged.layers.sums, whole.layers.sums, atol=1e-13 * scale)
        # the same fit to rounding, magnified by the square of the condition
        np.testing.assert_allclose(merged.fit().polynomial(points), whole.fit().polynomial(points), atol=1e-9)


def test_with_the_points_nothing_is_left_out() -> None:
    points, normals = rough()
    options = FitOptions.of(geometric=False, criterion="none", max_degree=13, measure_zero_set=False)
    whole = ipcore.fit(points, normals, options)
    summed = Moments.of(points, normals, degree=13)
    split = summed.fit(options, points=points, normals=normals)
    assert (split.degree, split.input_sha256) == (whole.degree, whole.input_sha256) == (13, whole.input_sha256)
    for one, other in zip(split.steps, whole.steps, strict=True):
        assert one.d_dist == pytest.approx(other.d_dist, rel=1e-9)
    with pytest.raises(InvalidPointsError, match="moments of 6000 points, not of 5999"):
        summed.fit(options, points=points[1:], normals=normals[1:])


def test_parts_of_a_set_need_not_be_sets_that_can_be_fitted() -> None:
    square = np.array([[x, y] for x in (0.0, 1.0) for y in np.linspace(0.0, 1.0, 20)])
    normals = np.repeat([[-1.0, 0.0], [1.0, 0.0]], 20, axis=0)
    frame = ipcore.Frame.of(square)
    left, right = (Moments.of(square[s], normals[s], degree=2, frame=frame) for s in (slice(20), slice(20, None)))
    whole = Moments.of(square, normals, degree=2)
    np.testing.assert_allclose(
        (left + right).layers.sums, whole.layers.sums, atol=1e-13 * np.abs(whole.layers.sums).max()
    )


def test_with_the_points_neither_a_sample_nor_the_highest_degrees_are_needed() -> None:
    points, normals = rough()
    options = FitOptions.of(geometric=False, criterion="none", max_degree=8, measure_zero_set=False)
    some = Moments.of(points, normals, degree=5)
    bare = some.without_sample()
    large, small = BytesIO(), BytesIO()
    some.save(large)
    bare.save(small)
    assert small.tell() < large.tell() / 5
    small.seek(0)
    fit, whole = Moments.load(small).fit(options, points=points, normals=normals), ipcore.fit(points, normals, options)
    assert (fit.degree, fit.diagnostics.stray) == (8, whole.diagnostics.stray)
    for one, other in zip(fit.steps, whole.steps, strict=True):
        assert one.d_dist == pytest.approx(other.d_dist, rel=1e-9)
    with pytest.raises(InvalidPointsError, match="no sample"):
        bare.fit(FitOptions.of(geometric=False, max_degree=5))


def test_nothing_is_added_by_no_points() -> None:
    points, normals = rough(500)
    some = Moments.of(points, normals, degree=3)
    assert some.extended(np.zeros((0, 3)), np.zeros((0, 3))) is some


@pytest.mark.parametrize("place", ["file", "memory"])
def test_saved_moments_are_read_back(place: str, tmp_path: Path) -> None:
    points, normals = rough(800)
    some = Moments.of(points, normals, degree=4)
    target = tmp_path / "moments.npz" if place == "file" else BytesIO()
    some.save(target)
    if isinstance(target, BytesIO):
        target.seek(0)
    again = Moments.load(target)
    np.testing.assert_array_equal(again.layers.sums, some.layers.sums)
    assert (again.count, again.degree, again.layers.offsets) == (800, 4, some.layers.offsets)
    np.testing.assert_array_equal((again + some).box, some.box)
    np.testing.assert_array_equal(again.fit().polynomial.coefficients, some.fit().polynomial.coefficients)


def test_other_files_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", points=np.zeros((3, 2)))
    with pytest.raises(InvalidPointsError, match="not a file of moments"):
        Moments.load(tmp_path / "other.npz")
    (tmp_path / "text.npz").write_text("no archive")
    with pytest.raises(InvalidPointsError, match="not a file of moments"):
        Moments.load(tmp_path / "text.npz")


def test_moments_that_do_not_belong_together_do_not_add() -> None:
    points, normals = rough(500)
    some = Moments.of(points, normals, degree=4)
    thick = FitOptions(layer_distance=0.1, geometric=False)
    for other in (
        Moments.of(points[:400], normals[:400], degree=4),
        Moments.of(points, normals, degree=5),
        Moments.of(points, normals, degree=4, options=thick),
    ):
        with pytest.raises(InvalidOptionsError, match="moments add only"):
            _ = some + other


def test_options_that_moments_cannot_give_are_refused() -> None:
    points, normals = rough(500)
    some = Moments.of(points, normals, degree=4)
    refused = {
        "linear fits only": FitOptions(max_degree=4),
        "reach up to degree 4": FitOptions.of(geometric=False, max_degree=5),
        "moments of layers at": FitOptions.of(geometric=False, layer_distance=0.1),
    }
    for words, options in refused.items():
        with pytest.raises(InvalidOptionsError, match=words):
            some.fit(options)
    with pytest.raises(InvalidOptionsError, match="linear fits only"):
        some.fit(FitOptions.of(criterion="loo"))
    with pytest.raises(InvalidOptionsError, match="3l and 5l"):
        Moments.of(points, normals, degree=4, options=FitOptions.of(constraints="taubin"))
    with pytest.raises(InvalidPointsError, match="3 columns"):
        some.extended(points[:, :2], normals[:, :2])
