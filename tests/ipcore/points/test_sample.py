import numpy as np
import pytest

from ipcore.points.sample import Sample


def test_a_sample_is_random_but_the_same_for_the_same_points() -> None:
    points = np.random.default_rng(0).uniform(size=(4000, 2))
    sample = Sample.of(points, points, 1000)
    assert len(np.unique(sample.points, axis=0)) == 1000
    np.testing.assert_array_equal(sample.points, sample.normals)
    np.testing.assert_array_equal(Sample.of(points[::-1], points[::-1], 1000).points, sample.points)
    # the mean of n uniform numbers is off by 0.29/√n, half of the points by the same in the other direction
    assert np.abs(sample.points.mean(axis=0) - points.mean(axis=0)).max() < 4.0 * 0.29 / np.sqrt(1000)


@pytest.mark.parametrize("parts", [2, 7])
def test_the_sample_of_parts_is_that_of_the_whole(parts: int) -> None:
    points = np.random.default_rng(1).normal(size=(3000, 3))
    joined = Sample.empty(3)
    for part in np.array_split(points, parts):
        joined = joined.with_more(Sample.of(part, part, 500), 500)
    np.testing.assert_array_equal(joined.points, Sample.of(points, points, 500).points)


def test_zero_has_one_key_whatever_its_sign() -> None:
    keys = Sample.of(np.array([[0.0, 1.0], [-0.0, 1.0]]), np.ones((2, 2))).keys
    assert keys[0] == keys[1]


def test_coordinates_that_are_swapped_have_other_keys() -> None:
    keys = Sample.of(np.array([[2.0, 1.0], [1.0, 2.0]]), np.ones((2, 2))).keys
    assert keys[0] != keys[1]
