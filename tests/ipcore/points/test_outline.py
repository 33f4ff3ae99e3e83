"""What is an outline, and its normals against those of circles and ellipses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipcore.errors import InvalidPointsError
from ipcore.points.outline import _is_closed, is_outline, outline_normals
from tests.ipcore.points.round_shapes import cosine, ellipse, mixed

# is it an outline?


@pytest.mark.parametrize("n", [12, 100, 3000])
def test_order_counts_and_disorder_does_not(n: int) -> None:
    points, _ = ellipse(n, 3.0, 1.0)
    assert is_outline(points)
    assert is_outline(np.roll(points[::-1], 5, axis=0))
    assert is_outline(np.vstack([points, points[:1]]))
    assert not is_outline(mixed(points)[0])


def test_few_points_in_random_order_are_no_outline() -> None:
    points, _ = ellipse(12)
    rng = np.random.default_rng(0)
    assert not any(is_outline(rng.permutation(points)) for _ in range(1000))


def test_random_points_are_no_outline() -> None:
    assert not is_outline(np.random.default_rng(0).normal(size=(200, 2)))
    assert not is_outline(np.zeros((5, 2)))


def test_noise_beyond_the_spacing_ends_the_order() -> None:
    points, _ = ellipse(400)
    noise = 2 * np.pi / 400 * np.random.default_rng(0).normal(size=points.shape)
    assert is_outline(points + 0.3 * noise)
    assert not is_outline(points + 1.5 * noise)


def test_raster_order_is_no_outline() -> None:
    points = np.round(20 * ellipse(200)[0])
    assert not is_outline(np.unique(points, axis=0))


def test_several_outlines_and_lines_are_outlines() -> None:
    points, _ = ellipse(60)
    assert is_outline(np.vstack([points, points + np.array([9.0, 0.0]), 0.3 * points]))
    assert is_outline(np.column_stack([np.arange(30.0), 2 * np.arange(30.0)]))


# along an outline


@settings(deadline=None, max_examples=30)
@given(st.integers(3, 300), st.booleans(), st.integers(0, 300), st.booleans())
def test_circle_is_exact_from_either_side_and_any_start(n: int, back: bool, start: int, close: bool) -> None:
    points = np.roll(ellipse(n)[0], start, axis=0)[:: -1 if back else 1]
    points = np.vstack([points, points[:1]]) if close else points
    np.testing.assert_allclose(outline_normals(points), points, atol=1e-9)


def test_error_on_an_ellipse_falls_with_the_square_of_the_spacing() -> None:
    errors = []
    for n in (100, 200, 400):
        points, true = ellipse(n, 2.0, 1.0)
        errors.append(np.linalg.norm(outline_normals(points) - true, axis=1).max())
    assert (np.diff(np.log2(errors)) < -1.8).all()


def test_concave_outline_points_outward() -> None:
    turn = 2 * np.pi * np.arange(400) / 400
    radius = 1 + 0.6 * np.cos(5 * turn)
    c, s = np.cos(turn), np.sin(turn)
    slope = -3.0 * np.sin(5 * turn)
    true = np.column_stack([radius * c + slope * s, radius * s - slope * c])
    points = radius[:, None] * np.column_stack([c, s])
    assert cosine(outline_normals(points), true / np.linalg.norm(true, axis=1, keepdims=True)).min() > 0.95


def test_repeated_points_along_the_way_change_nothing() -> None:
    points, _ = ellipse(80, 2.0, 1.0)
    found = outline_normals(np.repeat(points, 3, axis=0))
    np.testing.assert_array_equal(found, np.repeat(outline_normals(points), 3, axis=0))


@pytest.mark.parametrize("inner", [1, -1])
def test_annulus_has_its_hole_wherever_the_loops_run(inner: int) -> None:
    points, true = ellipse(120)
    ring = np.vstack([2 * points, points[::inner], 0.3 * points])
    found = outline_normals(ring)
    np.testing.assert_allclose(found, np.vstack([true, -true[::inner], true]), atol=1e-9)


def test_many_separate_outlines() -> None:
    points, true = ellipse(30)
    discs = np.vstack([points + np.array([4.0 * k, 0.0]) for k in range(100)])
    np.testing.assert_allclose(outline_normals(discs), np.tile(true, (100, 1)), atol=1e-9)


def test_open_arc_points_away_from_its_chord() -> None:
    points, true = ellipse(100)
    found = outline_normals(points[10:60])
    np.testing.assert_allclose(found[2:-2], true[12:58], atol=1e-9)
    assert cosine(found, true[10:60]).min() > 0.99


def test_straight_edges_between_dense_arcs_are_edges() -> None:
    """A stadium of which only the round ends are sampled."""
    turn = np.linspace(-np.pi / 2, np.pi / 2, 50)
    true = np.column_stack([np.cos(turn), np.sin(turn)])
    stadium = np.vstack([true + np.array([3.0, 0.0]), -true - np.array([3.0, 0.0])])
    assert is_outline(stadium)
    assert cosine(outline_normals(stadium), np.vstack([true, -true])).min() > 0.99


def test_gaps_leave_a_closed_outline_closed() -> None:
    points, true = ellipse(100)
    kept = np.r_[0:30, 36:70, 75:100]
    start = [0, 1, -2, -1]  # would be one-sided at the ends of an open curve, to 1e-4 and worse
    np.testing.assert_allclose(outline_normals(points[kept])[start], true[kept][start], atol=1e-9)


def test_pixel_staircase_is_smoothed() -> None:
    points = np.round(40 * ellipse(4000)[0])
    true = points / np.linalg.norm(points, axis=1, keepdims=True)
    assert is_outline(points)
    assert cosine(outline_normals(points), true).mean() > 0.97


def test_straight_line_has_one_side_and_a_spike_has_normals() -> None:
    line = np.column_stack([np.arange(20.0), 3 * np.arange(20.0)])
    np.testing.assert_allclose(np.abs(outline_normals(line) @ [3.0, -1.0]), 10**0.5, rtol=1e-12)
    there_and_back = np.vstack([line, line[-2:0:-1]])
    assert np.isfinite(outline_normals(there_and_back)).all()


def test_equal_points_have_no_outline() -> None:
    with pytest.raises(InvalidPointsError, match="distinct"):
        outline_normals(np.ones((4, 2)))


def test_a_curve_is_closed_if_its_gap_is_within_a_jump_and_half_its_length() -> None:
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]])  # the gap is 1 and half of the length too
    bent = np.array([[0.0, 0.0], [1.0, 0.0], [1.5, 0.75**0.5]])  # the gap is √3 of a length of 2
    assert _is_closed(triangle, 3.0)
    assert not _is_closed(triangle, 0.9)
    assert not _is_closed(bent, 3.0)
    assert not _is_closed(triangle[:2], 3.0)
