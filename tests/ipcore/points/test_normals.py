"""Estimated normals against those of circles, ellipses, spheres and tori."""

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
from ipcore.points.outline import outline_normals
from ipcore.points.winding import self_check
from tests.ipcore.points.round_shapes import cosine, ellipse, mixed, sphere, torus

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
def test_plane_or_line_has_one_side(planar: bool) -> None:
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
