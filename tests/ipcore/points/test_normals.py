"""Normals against those of circles, ellipses, spheres and tori."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree

from ipcore._typing import FloatArray
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.points.normals import NormalSource, _spanning_forest, _weights, estimate_normals, orient
from ipcore.points.outline import _is_closed, is_outline, outline_normals
from ipcore.points.winding import self_check


def ellipse(n: int, a: float = 1.0, b: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return points at even parameters and their outward normals."""
    turn = 2 * np.pi * np.arange(n) / n
    c, s = np.cos(turn), np.sin(turn)
    normals = np.column_stack([b * c, a * s])
    return np.column_stack([a * c, b * s]), normals / np.linalg.norm(normals, axis=1, keepdims=True)


def sphere(n: int) -> FloatArray:
    """Return the golden spiral on the unit sphere: points, and normals too."""
    height = 1 - (2 * np.arange(n) + 1) / n
    turn, radius = np.pi * (1 + 5**0.5) * np.arange(n), np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def torus(n: int, minor: float = 0.4) -> tuple[FloatArray, FloatArray]:
    u, v = np.random.default_rng(0).uniform(0, 2 * np.pi, (2, n))
    normals = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    return np.column_stack([np.cos(u), np.sin(u), 0 * u]) + minor * normals, normals


def mixed(*arrays: FloatArray) -> list[FloatArray]:
    """Return arrays with their rows in one random order."""
    order = np.random.default_rng(3).permutation(len(arrays[0]))
    return [array[order] for array in arrays]


def cosine(found: FloatArray, true: FloatArray) -> FloatArray:
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, rtol=1e-12)
    return np.asarray((found * true).sum(axis=1))


# estimated


def test_estimated_circle_is_exact_by_symmetry() -> None:
    points, true = mixed(*ellipse(100))
    np.testing.assert_allclose(cosine(estimate_normals(points), true), 1.0, rtol=1e-10)


def test_estimated_sphere_and_torus_point_outward() -> None:
    assert cosine(estimate_normals(sphere(1000)), sphere(1000)).min() > 0.99
    points, true = torus(4000)
    assert cosine(estimate_normals(points), true).min() > 0.8
    assert self_check(points, estimate_normals(points)) > 0.98


def test_estimates_converge_with_the_spacing() -> None:
    errors = []
    for n in (500, 2000, 8000):
        x = sphere(n) * [1.0, 1.0, 0.7]
        true = x / [1.0, 1.0, 0.49]
        true /= np.linalg.norm(true, axis=1, keepdims=True)
        errors.append(np.linalg.norm(estimate_normals(x) - true, axis=1).mean())
    slopes = np.diff(np.log(errors)) / np.log(0.5)  # spacing halves each time
    assert (slopes > 0.8).all()


def test_estimate_withstands_noise_of_half_a_spacing() -> None:
    true = sphere(3000)
    noisy = true + 0.5 * np.sqrt(4 * np.pi / 3000) * np.random.default_rng(0).normal(size=true.shape)
    assert (cosine(estimate_normals(noisy, 24), true) > 0).mean() > 0.99


@pytest.mark.parametrize("d", [2, 3])
def test_signs_cross_no_thin_part(d: int) -> None:
    """A lens, two to five spacings thick: its sides are parallel, but the edges between them leave both."""
    round_, thin = (ellipse(200)[0], 0.07) if d == 2 else (sphere(2000), 0.1)
    axes = np.append(np.ones(d - 1), thin)
    points, true = mixed(round_ * axes, round_ / axes)
    assert (cosine(estimate_normals(points), true) > 0).all()


def test_separate_pieces_are_turned_outward_each() -> None:
    points, true = ellipse(60)
    both, normals = mixed(np.vstack([points, points + np.array([5.0, 0.0])]), np.vstack([true, true]))
    assert cosine(estimate_normals(both), normals).min() > 0.99


@pytest.mark.parametrize("depth", [2, 3])
def test_nested_pieces_alternate(depth: int) -> None:
    """Shells of radius 1, 2, …: the outermost is turned outward, the next is the wall of a hole, and so on."""
    signs = [(-1.0) ** k for k in range(depth)]
    shells = np.vstack([(depth - k) * sphere(1500) for k in range(depth)])
    true = np.vstack([sign * sphere(1500) for sign in signs])
    points, true = mixed(shells, true)
    assert cosine(estimate_normals(points), true).min() > 0.99


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000), st.floats(-4, 4))
def test_estimate_moves_with_the_points(seed: int, power: float) -> None:
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = sphere(300) * [1.0, 0.8, 0.6]
    moved = 10.0**power * (points @ Q + rng.normal(size=3))
    np.testing.assert_allclose(estimate_normals(moved), estimate_normals(points) @ Q, atol=1e-8)


def test_repeated_points_share_their_normal() -> None:
    points = np.repeat(sphere(400), 20, axis=0)  # more copies than neighbours
    found = estimate_normals(points)
    np.testing.assert_array_equal(found, np.repeat(found[::20], 20, axis=0))
    assert cosine(found, points).min() > 0.98


def test_signed_zeros_are_the_same_point() -> None:
    points = np.vstack([sphere(50), [[0.0, 0.0, 1.5], [-0.0, 0.0, 1.5]]])
    found = estimate_normals(points)
    np.testing.assert_array_equal(found[-1], found[-2])


@pytest.mark.parametrize("d", [2, 3])
def test_fewest_points_lie_on_one_plane(d: int) -> None:
    found = estimate_normals(np.eye(d))
    np.testing.assert_allclose(np.abs(found), d**-0.5, rtol=1e-12)
    assert np.ptp(found, axis=0).max() < 1e-12
    assert np.isfinite(estimate_normals(np.vstack([np.zeros(d), np.eye(d)]))).all()


@pytest.mark.parametrize("planar", [True, False])
def test_plane_or_line_has_one_side(planar: bool) -> None:  # noqa: FBT001 - a parameter of the test
    t = np.random.default_rng(0).uniform(-1, 1, (300, 2))
    axes = np.array([[2.0, 1.0, 0.0], [0.0, 1.0, 3.0]])
    found = estimate_normals(t @ axes if planar else t[:, :1] @ axes[:1])
    assert np.abs(found @ axes[0]).max() < 1e-6
    if planar:
        assert np.ptp(found, axis=0).max() < 1e-6


@pytest.mark.parametrize("points", [np.zeros((5, 2)), np.ones((1, 3)), np.repeat(np.eye(3)[:2], 4, axis=0)])
def test_too_few_distinct_points_are_refused(points: FloatArray) -> None:
    with pytest.raises(InvalidPointsError, match="distinct"):
        estimate_normals(points)


@pytest.mark.parametrize("shape", [(4,), (4, 1), (4, 4), (2, 2, 2)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(InvalidPointsError, match="shape"):
        estimate_normals(np.zeros(shape))


@pytest.mark.parametrize("neighbours", [2, 0, -1])
def test_too_few_neighbours_are_refused(neighbours: int) -> None:
    with pytest.raises(InvalidOptionsError) as caught:
        orient(sphere(20), neighbours)
    assert caught.value.at == ("neighbours",)
    with pytest.raises(InvalidOptionsError):
        estimate_normals(sphere(20), neighbours)


@pytest.mark.parametrize("n", [50, 3000])
def test_spanning_forest_is_as_light_as_that_of_all_edges(n: int) -> None:
    p, neighbours = np.vstack([torus(n)[0], torus(n)[0] + 9.0]), 6
    normals = torus(n)[1][np.random.default_rng(1).permutation(np.tile(np.arange(n), 2))]  # any will do
    distances, indices = cKDTree(p).query(p, k=neighbours + 1)
    near, r = np.asarray(indices)[:, 1:], np.asarray(distances)[:, 1:]
    forest = _spanning_forest(p, normals, near, r)
    i, j = np.repeat(np.arange(2 * n), neighbours), near.ravel()
    whole = minimum_spanning_tree(csr_array((_weights(p, normals, i, j), (i, j)), shape=(2 * n, 2 * n)))
    assert forest.nnz == whole.nnz
    assert forest.sum() == pytest.approx(whole.sum(), rel=1e-12)


def test_normals_do_not_depend_on_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    points, _ = torus(40_000)
    found = []
    for threads in ("1", "3"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        found.append(estimate_normals(points))
    np.testing.assert_array_equal(found[0], found[1])


def test_normals_go_with_their_points_whatever_the_order() -> None:
    points, _ = torus(3000)
    order = np.random.default_rng(5).permutation(len(points))
    np.testing.assert_allclose(estimate_normals(points[order]), estimate_normals(points)[order], atol=1e-9)


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
def test_circle_is_exact_from_either_side_and_any_start(n: int, back: bool, start: int, close: bool) -> None:  # noqa: FBT001
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


# which of the two


def test_orient_says_what_it_did() -> None:
    points, true = ellipse(100)
    found, source = orient(points)
    assert source is NormalSource.OUTLINE
    np.testing.assert_array_equal(found, outline_normals(points))
    points, true = mixed(points, true)
    found, source = orient(points)
    assert source is NormalSource.ESTIMATED
    assert cosine(found, true).min() > 0.99
    assert orient(sphere(50))[1] is NormalSource.ESTIMATED


def test_a_curve_is_closed_if_its_gap_is_within_a_jump_and_half_its_length() -> None:
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]])  # the gap is 1 and half of the length too
    bent = np.array([[0.0, 0.0], [1.0, 0.0], [1.5, 0.75**0.5]])  # the gap is √3 of a length of 2
    assert _is_closed(triangle, 3.0)
    assert not _is_closed(triangle, 0.9)
    assert not _is_closed(bent, 3.0)
    assert not _is_closed(triangle[:2], 3.0)
