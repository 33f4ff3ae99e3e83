"""Distances by bins against distances asked for one by one."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ipcore._typing import FloatArray
from ipcore.polynomial.frame import Frame
from ipcore.zero_set.support import (
    BINS,
    SUPPORT_RADII,
    SUPPORT_SPACINGS,
    distances_exceeded,
    gap_radius,
    is_stray,
    radii_exceeded,
    support_radius,
)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("radii", [(0.3, 0.5), (0.02, 0.9), (0.4, 0.4)])
def test_bins_give_what_the_points_give(d: int, radii: tuple[float, ...]) -> None:
    rng = np.random.default_rng(d)
    data = rng.normal(size=(300, d))
    x = 1e3 + 3.0 * rng.normal(size=(40_000, d)) * np.array([1.0, 0.01, 0.3])[:d]
    tree = cKDTree(data + 1e3)
    direct = np.asarray(tree.query(x)[0])
    expected = sum((direct > radius).astype(int) for radius in radii)
    for threads in (1, 3):
        np.testing.assert_array_equal(distances_exceeded(tree, x, radii, threads), expected)


def test_a_distance_that_is_just_reached_is_not_distances_exceeded() -> None:
    tree = cKDTree([[0.0, 0.0]])
    assert distances_exceeded(tree, np.array([[3.0, 4.0], [3.0, 4.0 + 1e-12]]), (5.0,)).tolist() == [0, 1]
    assert distances_exceeded(tree, np.empty((0, 2)), (5.0,)).tolist() == []


def lattice(d: int, count: int) -> FloatArray:
    """Return the points with whole coordinates 0 … count − 1, (count^d, d)."""
    return np.stack(np.meshgrid(*[np.arange(float(count))] * d, indexing="ij"), axis=-1).reshape(-1, d)


@pytest.mark.parametrize(("d", "radii"), [(2, (3.0, 5.0)), (2, (5.0, 13.0)), (2, (1.0, 1.0)), (3, (3.0, 7.0))])
def test_points_on_the_borders_of_bins_and_at_the_radii_are_counted_right(d: int, radii: tuple[float, ...]) -> None:
    """Distances of a lattice are exact; with 64 bins along 0 … 64, all points lie on the borders of bins."""
    x = lattice(d, BINS + 1)
    tree = cKDTree([[20.0] * d, [41.0] * d])
    direct = np.asarray(tree.query(x)[0])
    assert all((direct == radius).any() for radius in radii)
    expected = sum((direct > radius).astype(int) for radius in radii)
    np.testing.assert_array_equal(distances_exceeded(tree, x, radii), expected)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("reach", [1.0, 3.0, 4.0, 5.0, 7.0, 30.0])
def test_points_are_stray_beyond_the_support_radius_whatever_the_size_of_bins(d: int, reach: float) -> None:
    """The farther points reach, the larger are the bins: from a fraction of the radius to several times as much."""
    rng = np.random.default_rng(d)
    data = rng.normal(size=(900, d))
    data /= np.linalg.norm(data, axis=1, keepdims=True)
    x = np.vstack([data + 0.3 * rng.normal(size=data.shape), rng.uniform(-reach, reach, (20_000, d))])
    distance = np.asarray(cKDTree(data).query(x)[0])
    np.testing.assert_array_equal(is_stray(x, data), distance > support_radius(data, Frame.of(data).scale))


def test_the_radius_is_the_larger_of_the_two() -> None:
    line = np.column_stack([np.arange(100.0), np.zeros(100)])  # mean radius 25, spacing 1
    assert support_radius(line, 25.0) == pytest.approx(max(25.0 * SUPPORT_RADII[2], SUPPORT_SPACINGS))
    assert support_radius(line, 25.0) == SUPPORT_SPACINGS
    assert support_radius(line, 100.0) == pytest.approx(10.0)


def test_points_within_between_and_beyond_the_two_radii() -> None:
    """Pairs of points: the nearest other one is 0.1 away, the 6th nearest 3, or more at the ends."""
    data = np.column_stack([np.arange(200) // 2 + 0.1 * (np.arange(200) % 2), np.zeros(200)])
    support, gap = support_radius(data, Frame.of(data).scale), gap_radius(data)
    assert 2.0 < 1.02 * support < 0.98 * gap < 8.0
    x = np.array([[50.0, y] for y in (0.0, 0.99 * support, 1.01 * support, 0.99 * gap, 1.01 * gap, 100.0)])
    assert radii_exceeded(x, data).tolist() == [0, 0, 1, 1, 2, 2]
