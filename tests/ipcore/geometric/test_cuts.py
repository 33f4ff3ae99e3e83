import numpy as np

from ipcore.geometric.cuts import cuts
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.violations import ViolationGrid
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
