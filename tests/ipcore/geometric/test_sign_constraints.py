import numpy as np
import pytest

from ipcore import shapes
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.geometric.sign_constraints import BOUNDS_GROWTH, SignNodes, SignPoints, lobatto
from ipcore.polynomial import evaluation, graded, gram, univariate
from ipcore.polynomial.univariate import Basis

EPS = np.finfo(float).eps
DEGREE = 4
MADE = {2: shapes.ellipse, 3: shapes.torus}


def nodes(d: int) -> SignNodes:
    shape = MADE[d]()
    points, normals = shape.sample(500)
    return SignNodes.of(InsideOutside(points, normals, shape.polynomial.bounds), shape.polynomial.bounds, 17, 10.0)


@pytest.mark.parametrize("d", [2, 3])
def test_nodes_and_the_same_places_one_by_one_agree(d: int) -> None:
    grid = nodes(d)
    t = np.stack(np.meshgrid(*[lobatto(17)] * d, indexing="ij"), axis=-1).reshape(-1, d)
    weights = np.full(len(t), grid.weight)
    places = SignPoints(t, grid.side.ravel(), grid.margin.ravel(), weights)
    tensor = evaluation.to_tensor(np.random.default_rng(0).normal(size=graded.count(d, DEGREE)), d, DEGREE)
    v, w = grid.shortfall(tensor), places.shortfall(tensor)
    size = np.abs(tensor).sum() * BOUNDS_GROWTH ** (4 * DEGREE)
    np.testing.assert_allclose(w, v.ravel(), atol=64.0 * EPS * size)
    assert (v > 0.0).any()
    assert places.cost(w) == pytest.approx(grid.cost(v), rel=1e-10)
    np.testing.assert_allclose(places.half_descent(w, DEGREE), grid.half_descent(v, DEGREE), atol=1e-12 * size)
    np.testing.assert_allclose(places.active(w, DEGREE), grid.active(v, DEGREE), atol=1e-11)


@pytest.mark.parametrize("d", [2, 3])
def test_pull_and_active_are_sums_over_places(d: int) -> None:
    generator = np.random.default_rng(0)
    t, weights = generator.uniform(-1.0, 1.0, (60, d)), generator.uniform(size=60)
    places = SignPoints(t, np.sign(generator.normal(size=60)), np.full(60, 0.1), weights)
    a = generator.normal(size=graded.count(d, DEGREE))
    v = places.shortfall(evaluation.to_tensor(a, d, DEGREE))
    tables = [univariate.table(Basis.CHEBYSHEV, row, DEGREE) for row in t.T]
    P = graded.products(tables, graded.exponents(d, DEGREE))
    np.testing.assert_allclose(v, np.maximum(0.0, 0.1 - places.side * (a @ P)), atol=1e-13)
    np.testing.assert_allclose(places.half_descent(v, DEGREE), P @ (weights * places.side * v), atol=1e-12)
    H = gram.gram(places.active(v, DEGREE), d, DEGREE)[0]
    np.testing.assert_allclose(H, (P * weights * (v > 0.0)) @ P.T, atol=1e-12)


def test_the_shape_itself_falls_short_nowhere() -> None:
    shape = shapes.circle()
    points, normals = shape.sample(300)
    bounds = shape.polynomial.bounds
    grid = SignNodes.of(InsideOutside(points, normals, bounds), bounds, 33, 10.0)
    r = (
        BOUNDS_GROWTH * 1.4
    )  # x² + y² − 1 in t on the bounds, x = 1.4 t: its slope at the circle is 2, and the margins' ½
    tensor = np.zeros((3, 3))
    tensor[0, 0], tensor[2, 0], tensor[0, 2] = 1.4**2 - 1.0, 1.4**2 / 2.0, 1.4**2 / 2.0
    assert r > 1.4
    assert grid.shortfall(tensor).max() == 0.0
    assert grid.shortfall(-tensor).max() > 0.1
    assert grid.unsure < 0.01


def test_what_stays_wrong_gets_more_weight() -> None:
    places = SignPoints(np.zeros((3, 2)), np.ones(3), np.full(3, 0.1), np.ones(3))
    heavier = places.reweighted(np.array([0.0, 0.05, 0.2]), 3.0)  # right, right but barely, wrong
    assert heavier.weight.tolist() == [1.0, 1.0, 3.0]
    assert places.with_more(heavier).weight.tolist() == [1.0, 1.0, 1.0, 1.0, 1.0, 3.0]
    assert nodes(2).heavier(4.0).weight == 4.0 * nodes(2).weight
