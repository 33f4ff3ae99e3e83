from collections.abc import Callable

import numpy as np
import pytest

from ipcore import shapes
from ipcore.shapes import Shape
from ipcore.zero_set.zero_set import zero_set

EVERY = [*shapes.CURVES, *shapes.SURFACES]


@pytest.mark.parametrize("make", EVERY)
def test_samples_lie_on_the_shape_with_outward_unit_normals(make: Callable[[], Shape]) -> None:
    shape = make()
    points, normals = shape.sample(200)
    assert points.shape == normals.shape == (200, shape.polynomial.dimension)
    assert np.abs(shape.polynomial.distance(points)).max() < 1e-13
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-14)
    assert (shape.polynomial(points + 1e-3 * normals) > 0.0).all()
    assert (shape.polynomial(points - 1e-3 * normals) < 0.0).all()


@pytest.mark.parametrize("make", EVERY)
def test_zero_set_is_one_closed_component_of_the_stated_topology(make: Callable[[], Shape]) -> None:
    shape = make()
    found = zero_set(shape.polynomial, resolution=64)
    edges = np.unique(
        np.sort(np.concatenate([found.cells[:, [0, 1]], found.cells[:, [-1, 0]], found.cells[:, -2:]])), axis=0
    )
    if shape.polynomial.dimension == 2:
        edges = found.cells
    euler = len(found.vertices) - len(edges) + (len(found.cells) if shape.polynomial.dimension == 3 else 0)
    assert found.components == 1
    assert euler == shape.euler


def test_samples_are_spread_by_area() -> None:
    points, _ = shapes.sphere().sample(20_000)
    shares = np.histogram(points[:, 2], bins=10, range=(-1.0, 1.0))[0] / len(points)
    np.testing.assert_allclose(shares, 0.1, atol=0.01)  # Archimedes: equal heights of a sphere have equal areas


def test_the_same_seed_gives_the_same_points() -> None:
    np.testing.assert_array_equal(shapes.torus().sample(50, seed=3)[0], shapes.torus().sample(50, seed=3)[0])
