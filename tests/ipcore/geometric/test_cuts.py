from dataclasses import replace

import numpy as np
import pytest

from ipcore._typing import BoolArray, FloatArray
from ipcore.geometric.cuts import CUT_SLOPE, LARGEST_CUT_MARGIN, UNKNOWN_SIDE_MARGIN, cuts
from ipcore.geometric.inside_outside import BLIND_RADII, InsideOutside
from ipcore.geometric.violations import ViolationGrid, Violations
from tests.ipcore.geometric.circles import BOUNDS, CIRCLE, multiplied, tensor_of, unit_circle


def test_a_second_piece_away_from_the_points_is_found_and_forbidden() -> None:
    sides = unit_circle()
    grid = ViolationGrid(sides, BOUNDS, 101)
    line = tensor_of({(0, 0): 1.2, (1, 0): 1.0})  # x = −1.2, a line outside of the circle: f < 0 beyond it
    product = multiplied(CIRCLE, line)
    found = grid.find(product)
    assert found.components == 2
    assert found.stray > 0.1
    added = cuts(found, grid, sides)
    assert added is not None
    x = 1.3 * added.t[:, 0]
    wrong = x < -1.2
    assert wrong.any()
    assert (added.side[wrong] == 1.0).all()


def test_a_larger_circle_is_stray_and_gets_cuts_outside_of_the_data() -> None:
    sides = unit_circle()
    grid = ViolationGrid(sides, BOUNDS, 101)
    found = grid.find(tensor_of({(0, 0): -1.4, (2, 0): 1.0, (0, 2): 1.0}))  # radius 1.18, 0.18 away from all points
    assert found.stray == 1.0
    added = cuts(found, grid, sides)
    assert added is not None
    radius = 1.3 * np.hypot(*added.t.T)
    assert (added.side[radius > 1.05] == 1.0).all()


def test_two_shapes_are_two_components_and_need_no_cuts() -> None:
    turn = 2.0 * np.pi * np.arange(200) / 200
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    points = np.vstack([0.4 * circle + [-0.7, 0.0], 0.4 * circle + [0.7, 0.0]])
    sides = InsideOutside(points, np.vstack([circle, circle]), BOUNDS)
    grid = ViolationGrid(sides, BOUNDS, 101)
    # ((x + 0.7)² + y² − 0.16) ((x − 0.7)² + y² − 0.16)
    left = tensor_of({(0, 0): 0.33, (1, 0): 1.4, (2, 0): 1.0, (0, 2): 1.0})
    right = tensor_of({(0, 0): 0.33, (1, 0): -1.4, (2, 0): 1.0, (0, 2): 1.0})
    found = grid.find(multiplied(left, right))
    assert found.components == 2
    assert found.suspect.any()  # the smaller of the two regions, as any minor one
    assert cuts(found, grid, sides) is None


def test_a_part_cut_off_is_joined() -> None:
    # two squares joined by a bridge 0.03 thick, thinner than the blind radius, that the fit leaves out
    half = [[-1.0, -0.5], [-0.1, -0.5], [-0.1, -0.015], [0.1, -0.015], [0.1, -0.5], [1.0, -0.5]]
    corners = np.array(half + [[x, -y] for x, y in half[::-1]])
    steps = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(steps, axis=1)
    where = [np.arange(0.0, 1.0, 0.02 / length)[:, None] for length in lengths]
    points = np.vstack([c + w * s for c, w, s in zip(corners, where, steps, strict=True)])
    unit = np.column_stack([steps[:, 1], -steps[:, 0]]) / lengths[:, None]
    normals = np.vstack([np.tile(n, (len(w), 1)) for n, w in zip(unit, where, strict=True)])
    sides = InsideOutside(points, normals, BOUNDS)
    grid = ViolationGrid(sides, BOUNDS, 201)
    left = tensor_of({(0, 0): 0.1425, (1, 0): 1.1, (2, 0): 1.0, (0, 2): 1.0})
    right = tensor_of({(0, 0): 0.1425, (1, 0): -1.1, (2, 0): 1.0, (0, 2): 1.0})
    found = grid.find(multiplied(left, right))
    assert found.components == 2
    added = cuts(found, grid, sides)
    assert added is not None
    bridge = np.abs(1.3 * added.t).max(axis=1) < 0.05
    assert bridge.any()
    assert (added.side[bridge] == -1.0).all()


def distances(count: int) -> tuple[ViolationGrid, FloatArray]:
    """Return a grid, and at its nodes the signed distance from the unit circle."""
    grid = ViolationGrid(unit_circle(), BOUNDS, count)
    x = 1.3 * grid.lines
    return grid, np.hypot(x[:, None], x[None, :]) - 1.0


def violations(
    f: FloatArray, minor: BoolArray, suspect: BoolArray, subgrid: tuple[FloatArray, FloatArray] | None = None
) -> Violations:
    """Return violations as a grid shows them; at all other places f is -0.01."""
    places, values = subgrid or (np.zeros((0, 2)), np.zeros(0))
    return Violations(np.array([[-0.01]]), f, minor, suspect, places, values, 2, 0.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_region_within_the_blind_radius_gets_the_other_sign(side: float) -> None:
    grid, f = distances(401)
    x = 1.3 * grid.lines
    beside = (side * f > 0.2 * BLIND_RADII) & (side * f < 0.9 * BLIND_RADII) & (x[:, None] > 0.0) & (np.abs(x) < 0.05)
    assert beside.sum() > 5
    f[beside] *= -1.0
    added = cuts(violations(f, beside, beside), grid, unit_circle())
    assert added is not None
    first = slice(0, int(beside.sum()))
    assert (added.side[first] == side).all()
    assert (added.margin[first] == UNKNOWN_SIDE_MARGIN).all()
    np.testing.assert_array_equal(added.t[first], grid.places(beside))


def test_components_between_nodes_get_the_known_side_or_that_of_the_nearest_tangent() -> None:
    grid, f = distances(101)
    none = np.zeros(f.shape, dtype=np.bool_)
    places = np.array([[0.0, 0.0], [0.1, 0.0], [0.9, 0.9], [1.005 / 1.3, 0.0], [0.0, -0.995 / 1.3], [0.995 / 1.3, 0.0]])
    # wrong inside, right inside, wrong outside; beside the data wrong outside, wrong inside, right inside
    values = np.array([0.01, -0.01, -0.01, -0.01, 0.01, -0.01])
    added = cuts(violations(f, none, none, (places, values)), grid, unit_circle())
    assert added is not None
    np.testing.assert_array_equal(added.t, places[[0, 2, 3, 4]])
    assert added.side.tolist() == [-1.0, 1.0, 1.0, -1.0]
    assert (added.margin == UNKNOWN_SIDE_MARGIN).all()


def test_nodes_around_a_suspect_get_the_margin_that_grows_with_distance() -> None:
    grid, f = distances(101)
    wrong = np.zeros(f.shape, dtype=np.bool_)
    wrong[50, 91] = (
        True  # at (0, 1.066); the nearest node that is examined with it is at 1.014, within the blind radius
    )
    f = np.where(f > 0.0, 0.3 * CUT_SLOPE * f, f)  # outside the right sign, but with too little margin
    f[wrong] = -1.0
    sides = unit_circle()
    added = cuts(violations(f, np.zeros_like(wrong), wrong), grid, sides)
    assert added is not None
    assert len(added.t) == 12  # all within two steps, but for that one
    distance = sides.classify(grid.local(added.t)).distance
    np.testing.assert_array_equal(added.margin, np.minimum(CUT_SLOPE * distance, LARGEST_CUT_MARGIN))
    assert added.margin.min() < 0.6 * LARGEST_CUT_MARGIN
    assert (added.side == 1.0).all()


def test_nodes_with_enough_margin_get_no_cut() -> None:
    grid, f = distances(101)
    wrong = np.zeros(f.shape, dtype=np.bool_)
    wrong[50, 97] = True
    f[wrong] = -1.0
    added = cuts(violations(f, np.zeros_like(wrong), wrong), grid, unit_circle())
    assert added is not None
    np.testing.assert_array_equal(added.t, grid.places(wrong))


def strip(thickness: float) -> tuple[InsideOutside, ViolationGrid]:
    """Return the sides of a long rectangle about the x axis, 0.02 between points, and a grid that its middle misses."""
    x = np.arange(-1.0, 1.0, 0.02)
    along = np.vstack([np.column_stack([x, np.full_like(x, y)]) for y in (thickness / 2.0, -thickness / 2.0)])
    normals = np.vstack([np.tile([0.0, 1.0], (len(x), 1)), np.tile([0.0, -1.0], (len(x), 1))])
    sides = InsideOutside(along, normals, BOUNDS)
    return sides, ViolationGrid(sides, BOUNDS, 101)


@pytest.mark.parametrize("between", [-0.01, 0.01])
def test_pieces_of_a_thin_part_are_right_and_joined_only_where_f_divides_them(between: float) -> None:
    sides, grid = strip(0.02)
    f = np.ones((101, 101))
    f[20:40, 50] = f[60:70, 50] = -0.01  # inside the strip
    minor = np.zeros(f.shape, dtype=np.bool_)
    minor[60:70, 50] = True
    found = replace(violations(f, minor, minor), tensor=np.array([[between]]))
    added = cuts(found, grid, sides)
    assert (added is not None) == (between > 0.0)
    if added is not None:
        on_path = (np.abs(added.t[:, 1]) < 1e-9) & (added.margin == UNKNOWN_SIDE_MARGIN)
        assert (added.side[on_path] == -1.0).all()
        assert np.ptp(added.t[on_path, 0]) >= 20 * 0.02 - 1e-9


def test_where_the_shape_touches_itself_nothing_has_to_be_joined() -> None:
    turn = 2.0 * np.pi * np.arange(60) / 60
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    across = np.array([1.0, 0.0])
    sides = InsideOutside(0.5 * np.vstack([ring - across, ring + across]), np.vstack([ring, ring]), BOUNDS)
    assert sides.touching(np.array([[0.0, 0.0], [0.0, 0.01]])).tolist() == [True, True]
    assert sides.touching(np.array([[-1.0, 0.0], [0.5, 0.5]])).tolist() == [False, False]
