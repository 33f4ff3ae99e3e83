import numpy as np
import pytest

from ipcore.geometric.violations import ViolationGrid
from ipcore.zero_set.support import SUPPORT_RADII
from tests.ipcore.geometric.circles import BOUNDS, CIRCLE, multiplied, tensor_of, unit_circle


def test_a_circle_is_one_piece_and_keeps_to_its_points() -> None:
    found = ViolationGrid(unit_circle(), BOUNDS, 101).find(CIRCLE)
    assert (found.components, found.stray) == (1, 0.0)
    assert not found.suspect.any()


@pytest.mark.parametrize(
    ("radius", "stray"), [(1.0 + SUPPORT_RADII[2] - 0.03, 0.0), (1.0 + SUPPORT_RADII[2] + 0.03, 1.0)]
)
def test_a_circle_is_stray_beyond_the_support_radius(radius: float, stray: float) -> None:
    found = ViolationGrid(unit_circle(), BOUNDS, 201).find(tensor_of({(0, 0): -(radius**2), (2, 0): 1.0, (0, 2): 1.0}))
    assert found.stray == stray
    assert found.suspect.any() == bool(stray)
    assert not found.minor.any()


def test_the_smaller_region_of_a_sign_is_minor_and_suspect() -> None:
    line = tensor_of({(0, 0): 1.2, (1, 0): 1.0})  # x = −1.2, outside of the circle
    grid = ViolationGrid(unit_circle(), BOUNDS, 101)
    found = grid.find(multiplied(CIRCLE, line))
    assert found.components == 2
    x = grid.local(grid.places(found.minor))[:, 0]
    assert len(x) > 0
    assert (x < -1.2).all()
    assert (found.suspect[found.minor]).all()


def test_a_component_between_the_nodes_counts() -> None:
    small = tensor_of({(0, 0): 2.0 * 0.6**2 - 1e-6, (1, 0): -1.2, (0, 1): -1.2, (2, 0): 1.0, (0, 2): 1.0})
    found = ViolationGrid(unit_circle(), BOUNDS, 100).find(multiplied(CIRCLE, small))  # radius 0.001
    assert not found.minor.any()
    assert found.components == 2
    np.testing.assert_allclose(1.3 * found.subgrid, [[0.6, 0.6]], atol=5e-4)
