from collections.abc import Callable

import numpy as np
import pytest

from ipcore import shapes
from ipcore.geometric.inside_outside import BLIND_RADII, SEARCH_RADIUS, InsideOutside
from ipcore.shapes import Shape

MADE = (shapes.ellipse, shapes.cubic, shapes.superellipse, shapes.torus, shapes.genus_two)


@pytest.mark.parametrize("make", MADE)
def test_sides_are_those_of_the_polynomial(make: Callable[[], Shape]) -> None:
    shape = make()
    bounds = shape.polynomial.bounds
    points, normals = shape.sample(400 if len(bounds[0]) == 2 else 4000)
    places = np.random.default_rng(1).uniform(bounds[0], bounds[1], (4000, len(bounds[0])))
    located = InsideOutside(points, normals, bounds).classify(places)
    truth = np.sign(shape.polynomial(places))
    told = located.side != 0.0
    if make is shapes.cubic:  # its other branch is near the bounds' corner, but no data are
        told &= places[:, 0] < 0.0
    assert (located.side[told] == truth[told]).all()
    assert told.mean() > 0.75


def test_nothing_is_told_beside_the_data() -> None:
    points, normals = shapes.circle().sample(200)
    located = InsideOutside(points, normals, np.array([[-1.4, -1.4], [1.4, 1.4]])).classify(
        points + 0.5 * BLIND_RADII * normals
    )
    assert (located.side == 0.0).all()
    assert (located.distance < BLIND_RADII).all()


def test_distances_are_cut_at_the_search_radius() -> None:
    points, normals = shapes.circle().sample(200)
    located = InsideOutside(points, normals, np.array([[-1.4, -1.4], [1.4, 1.4]])).classify(
        np.array([[0.0, 0.0], [1.1, 0.0]])
    )
    assert located.distance[0] == SEARCH_RADIUS
    assert located.distance[1] == pytest.approx(0.1, abs=0.02)
    assert located.side.tolist() == [-1.0, 1.0]


def test_thin_parts_have_an_inside() -> None:
    # a slab 0.08 thick, its points 0.02 apart: the nearest normal is right on each face, and the ends are not
    x = np.arange(-1.0, 1.0, 0.02)
    points = np.vstack([np.column_stack([x, np.full(100, y)]) for y in (-0.04, 0.04)])
    normals = np.vstack([np.tile([0.0, -1.0], (100, 1)), np.tile([0.0, 1.0], (100, 1))])
    middle = np.column_stack([np.linspace(-0.9, 0.9, 50), np.zeros(50)])
    sides = InsideOutside(points, normals, np.array([[-1.3, -0.4], [1.3, 0.4]]))
    assert (sides.classify(middle).side == -1.0).all()
    assert (sides.classify(middle + np.array([0.0, 0.1])).side == 1.0).all()


def test_a_part_thinner_than_the_coarse_grid_has_an_inside() -> None:
    x = np.arange(-5.0, 5.0, 0.05)  # a slab 0.2 thick, in a box between two lines of the coarse grid, at ±0.16
    points = np.vstack([np.column_stack([x, np.full(len(x), y)]) for y in (-0.1, 0.1)])
    normals = np.vstack([np.tile([0.0, -1.0], (len(x), 1)), np.tile([0.0, 1.0], (len(x), 1))])
    sides = InsideOutside(points, normals, np.array([[-10.0, -10.0], [10.0, 10.0]]))
    along = np.linspace(-4.0, 4.0, 60)
    for y, side in ((-0.05, -1.0), (0.05, -1.0), (-0.2, 1.0), (0.2, 1.0)):
        assert (sides.classify(np.column_stack([along, np.full(60, y)])).side == side).all()


def test_half_a_sphere_is_sure_beside_its_surface_and_unsure_in_its_opening() -> None:
    points, normals = shapes.sphere().sample(4000)
    upper = points[:, 2] > 0.0
    sides = InsideOutside(points[upper], normals[upper], np.array([[-1.3, -1.3, -0.3], [1.3, 1.3, 1.3]]))
    up = points[points[:, 2] > 0.5][:100]
    assert (sides.classify(0.85 * up).side == -1.0).all()
    assert (sides.classify(1.15 * up).side == 1.0).all()
    opening = np.column_stack([np.linspace(-0.5, 0.5, 40), np.zeros(40), np.full(40, -0.25)])
    assert (sides.classify(opening).side == 0.0).mean() > 0.5
