import numpy as np
import pytest

from ipcore.polynomial.box import Box

EPS = float(np.finfo(float).eps)
BOUNDS = np.array([[1.0, -7.0, 100.0], [3.5, -2.0, 100.25]])


def test_corners_and_centre_go_to_those_of_the_cube() -> None:
    box = Box.of(BOUNDS)
    assert box.to_cube(BOUNDS).tolist() == [[-1.0] * 3, [1.0] * 3]
    assert box.to_cube(BOUNDS.mean(axis=0)).tolist() == [0.0] * 3
    np.testing.assert_array_equal(box.from_cube(np.array([[-1.0] * 3, [1.0] * 3])), BOUNDS)


@pytest.mark.parametrize("shape", [(3,), (7, 3), (2, 5, 3)])
def test_the_two_maps_are_inverse(shape: tuple[int, ...]) -> None:
    box, t = Box.of(BOUNDS), np.random.default_rng(0).uniform(-1.0, 1.0, shape)
    there = box.from_cube(t)
    assert there.shape == shape
    np.testing.assert_allclose(box.to_cube(there), t, atol=4.0 * EPS * (np.abs(BOUNDS).max(axis=0) / box.half).max())


def test_axis_by_axis_they_give_the_same() -> None:
    box, t = Box.of(BOUNDS), np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3))
    x = box.from_cube(t)
    for axis in range(3):
        np.testing.assert_array_equal(box.axis_from_cube(t[:, axis], axis), x[:, axis])
        np.testing.assert_array_equal(box.axis_to_cube(x[:, axis], axis), box.to_cube(x)[:, axis])
