import numpy as np

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.geometric.exchange import cuts
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.violations import ViolationGrid

BOUNDS = np.array([[-1.3, -1.3], [1.3, 1.3]])


def sampled() -> InsideOutside:
    points, normals = shapes.circle().sample(400)
    return InsideOutside(points, normals, BOUNDS)


def tensor_of(coefficients: dict[tuple[int, int], float]) -> FloatArray:
    """Return Chebyshev coefficients on the bounds of Σ c x^i y^j, i and j at most 2 and one of them 0."""
    h, out = 1.3, np.zeros((5, 5))
    for (i, j), c in coefficients.items():
        for k, power in ((i, (1, 0)), (j, (0, 1))):
            if k == 2:  # x² = h² (1 + T_2(t)) / 2
                out[0, 0] += c * h**2 / 2.0
                out[2 * power[0], 2 * power[1]] += c * h**2 / 2.0
        if i == j == 0:
            out[0, 0] += c
        if i + j == 1:
            out[i, j] += c * h
    return out


CIRCLE = tensor_of({(0, 0): -1.0, (2, 0): 1.0, (0, 2): 1.0})


def test_a_circle_is_one_piece_and_keeps_to_its_points() -> None:
    sides = sampled()
    survey = ViolationGrid(sides, BOUNDS, 101)
    found = survey.find(CIRCLE)
    assert (found.components, found.stray) == (1, 0.0)
    assert not found.suspect.any()


def test_a_second_piece_away_from_the_points_is_found_and_forbidden() -> None:
    sides = sampled()
    survey = ViolationGrid(sides, BOUNDS, 101)
    line = tensor_of({(0, 0): 1.2, (1, 0): 1.0})  # x = −1.2, a line outside of the circle: f < 0 beyond it
    product = multiplied(CIRCLE, line)
    found = survey.find(product)
    assert found.components == 2
    assert found.stray > 0.1
    asked = cuts(found, survey, sides)
    assert asked is not None
    x = 1.3 * asked.t[:, 0]
    wrong = x < -1.2
    assert wrong.any()
    assert (asked.side[wrong] == 1.0).all()


def test_a_larger_circle_is_stray_and_pulled_in() -> None:
    sides = sampled()
    survey = ViolationGrid(sides, BOUNDS, 101)
    found = survey.find(tensor_of({(0, 0): -1.4, (2, 0): 1.0, (0, 2): 1.0}))  # radius 1.18, 0.18 away from all points
    assert found.stray == 1.0
    asked = cuts(found, survey, sides)
    assert asked is not None
    radius = 1.3 * np.hypot(*asked.t.T)
    assert (asked.side[radius > 1.05] == 1.0).all()


def test_two_shapes_are_two_components_and_nothing_is_asked() -> None:
    turn = 2.0 * np.pi * np.arange(200) / 200
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    points = np.vstack([0.4 * circle + [-0.7, 0.0], 0.4 * circle + [0.7, 0.0]])
    sides = InsideOutside(points, np.vstack([circle, circle]), BOUNDS)
    survey = ViolationGrid(sides, BOUNDS, 101)
    # ((x + 0.7)² + y² − 0.16) ((x − 0.7)² + y² − 0.16)
    left = tensor_of({(0, 0): 0.33, (1, 0): 1.4, (2, 0): 1.0, (0, 2): 1.0})
    right = tensor_of({(0, 0): 0.33, (1, 0): -1.4, (2, 0): 1.0, (0, 2): 1.0})
    found = survey.find(multiplied(left, right))
    assert found.components == 2
    assert found.suspect.any()  # the smaller of the two regions, as any minor one
    assert cuts(found, survey, sides) is None


def test_a_part_cut_off_is_joined() -> None:
    # two squares joined by a bridge 0.03 thick, thinner than sides can tell, that the fit leaves out
    half = [[-1.0, -0.5], [-0.1, -0.5], [-0.1, -0.015], [0.1, -0.015], [0.1, -0.5], [1.0, -0.5]]
    corners = np.array(half + [[x, -y] for x, y in half[::-1]])
    steps = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(steps, axis=1)
    where = [np.arange(0.0, 1.0, 0.02 / length)[:, None] for length in lengths]
    points = np.vstack([c + w * s for c, w, s in zip(corners, where, steps, strict=True)])
    unit = np.column_stack([steps[:, 1], -steps[:, 0]]) / lengths[:, None]
    normals = np.vstack([np.tile(n, (len(w), 1)) for n, w in zip(unit, where, strict=True)])
    sides = InsideOutside(points, normals, BOUNDS)
    survey = ViolationGrid(sides, BOUNDS, 201)
    left = tensor_of({(0, 0): 0.1425, (1, 0): 1.1, (2, 0): 1.0, (0, 2): 1.0})
    right = tensor_of({(0, 0): 0.1425, (1, 0): -1.1, (2, 0): 1.0, (0, 2): 1.0})
    found = survey.find(multiplied(left, right))
    assert found.components == 2
    asked = cuts(found, survey, sides)
    assert asked is not None
    bridge = np.abs(1.3 * asked.t).max(axis=1) < 0.05
    assert bridge.any()
    assert (asked.side[bridge] == -1.0).all()


def multiplied(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the product of two polynomials of degree 2 or less in Chebyshev products, by values at 9 nodes."""
    nodes = np.cos(np.pi * (np.arange(9) + 0.5) / 9)
    values = np.polynomial.chebyshev.chebgrid2d(nodes, nodes, a) * np.polynomial.chebyshev.chebgrid2d(nodes, nodes, b)
    V = np.polynomial.chebyshev.chebvander(nodes, 8)
    inverse = np.linalg.inv(V)
    return np.asarray(inverse @ values @ inverse.T)[:5, :5]
