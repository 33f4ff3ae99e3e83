"""The radii, and points beyond them by bins against points asked for one by one."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ipcore.polynomial.frame import Frame
from ipcore.zero_set.support import (
    GAP_FACTOR,
    SUPPORT_RADII,
    SUPPORT_SPACINGS,
    gap_radius,
    is_beyond_support,
    support_radius,
)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("reach", [1.0, 3.0, 4.0, 5.0, 7.0, 30.0])
def test_points_are_beyond_the_support_radius_whatever_the_size_of_bins(d: int, reach: float) -> None:
    """The farther points reach, the larger are the bins: from a fraction of the radius to several times as much."""
    rng = np.random.default_rng(d)
    data = rng.normal(size=(900, d))
    data /= np.linalg.norm(data, axis=1, keepdims=True)
    x = np.vstack([data + 0.3 * rng.normal(size=data.shape), rng.uniform(-reach, reach, (20_000, d))])
    distance = np.asarray(cKDTree(data).query(x)[0])
    np.testing.assert_array_equal(is_beyond_support(x, data), distance > support_radius(data, Frame.of(data).scale))


def test_the_radius_is_the_larger_of_the_two() -> None:
    line = np.column_stack([np.arange(100.0), np.zeros(100)])  # mean radius 25, spacing 1
    assert support_radius(line, 25.0) == pytest.approx(max(25.0 * SUPPORT_RADII[2], SUPPORT_SPACINGS))
    assert support_radius(line, 25.0) == SUPPORT_SPACINGS
    assert support_radius(line, 100.0) == pytest.approx(10.0)


def test_the_gap_radius_follows_the_6th_nearest_point() -> None:
    """Pairs of points: the nearest other one is 0.1 away, the 6th nearest 3, or more at the ends."""
    data = np.column_stack([np.arange(200) // 2 + 0.1 * (np.arange(200) % 2), np.zeros(200)])
    assert support_radius(data, Frame.of(data).scale) == pytest.approx(2.5, abs=0.1)
    assert gap_radius(data) == pytest.approx(GAP_FACTOR * 4.0, rel=0.3)


@pytest.mark.parametrize("times", [2, 5, 9])
def test_repeated_points_do_not_change_the_radii(times: int) -> None:
    data = np.random.default_rng(0).uniform(size=(300, 3))
    copies = np.repeat(data, times, axis=0)
    assert support_radius(copies, 1.0) == pytest.approx(support_radius(data, 1.0), rel=1e-12)
    assert gap_radius(copies) == pytest.approx(gap_radius(data), rel=1e-12)
    assert gap_radius(np.ones((5, 2))) == 0.0


@pytest.mark.parametrize("count", [1024, 5000, 40_000])
def test_the_radii_of_many_points_are_estimated_by_some_of_them(count: int) -> None:
    data = np.random.default_rng(count).uniform(size=(count, 2))
    spacings = np.asarray(cKDTree(data).query(data, 7)[0])
    assert support_radius(data, 0.0) == pytest.approx(SUPPORT_SPACINGS * np.median(spacings[:, 1]), rel=0.1)
    assert gap_radius(data) == pytest.approx(GAP_FACTOR * np.quantile(spacings[:, 6], 0.99), rel=0.1)
