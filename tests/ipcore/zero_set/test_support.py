"""Distances by bins against distances asked for one by one."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ipcore.zero_set.support import distances_exceeded


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
