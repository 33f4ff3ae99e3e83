"""The winding number against solid angles known in closed form."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipcore._typing import FloatArray
from ipcore.points.winding import areas, self_check, winding_number


def circle(n: int, radius: float = 1.0, centre: tuple[float, float] = (0.0, 0.0)) -> tuple[FloatArray, FloatArray]:
    turn = 2 * np.pi * np.arange(n) / n
    normals = np.column_stack([np.cos(turn), np.sin(turn)])
    return radius * normals + centre, normals


def sphere(n: int) -> tuple[FloatArray, FloatArray]:
    """Return the golden spiral, nearly even, on the unit sphere."""
    height = 1 - (2 * np.arange(n) + 1) / n
    turn, radius = np.pi * (1 + 5**0.5) * np.arange(n), np.sqrt(1 - height**2)
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
    return points, points


def grid(n: int, size: float = 1.0) -> FloatArray:
    """Return n × n cell centres of a square in the plane z = 0."""
    line = size * ((np.arange(n) + 0.5) / n - 0.5)
    x, y = np.meshgrid(line, line)
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])


def test_areas_of_an_evenly_sampled_line_are_its_spacing() -> None:
    x = 0.25 * np.arange(40)
    length = areas(np.column_stack([3 * x, 4 * x]))
    np.testing.assert_allclose(length[2:-2], 1.25, rtol=1e-13)


def test_areas_of_a_square_grid_are_its_cells() -> None:
    area = areas(grid(20)).reshape(20, 20)[3:-3, 3:-3]
    np.testing.assert_allclose(area, 1 / 400, rtol=0.06)


@pytest.mark.parametrize("density", [500, 5000])
def test_areas_of_random_points_add_up_to_the_sphere(density: int) -> None:
    x = np.random.default_rng(0).normal(size=(density, 3))
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    assert areas(x).sum() == pytest.approx(4 * np.pi, rel=0.1)


def test_areas_scale_with_the_power_of_their_dimension() -> None:
    curve, surface = circle(50)[0], sphere(200)[0]
    np.testing.assert_allclose(areas(3 * curve), 3 * areas(curve), rtol=1e-12)
    np.testing.assert_allclose(areas(3 * surface), 9 * areas(surface), rtol=1e-12)


def test_points_given_twice_share_their_area() -> None:
    points = sphere(2000)[0]
    assert areas(np.repeat(points, 2, axis=0)).sum() == pytest.approx(areas(points).sum(), rel=0.15)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_areas_exist_for_as_few_as_two_points(n: int) -> None:
    assert (areas(np.eye(4)[:n, :3] + 0.0) > 0).all()


def test_even_circle_gives_the_angle_of_a_discrete_dipole_sum() -> None:
    """With lengths 2π/n the trapezoidal sum of Poisson's kernel is w = 1 / (1 − ρⁿ) on an axis through a point."""
    n, rho = 40, np.array([0.0, 0.3, 0.6, 0.8])
    points, normals = circle(n)
    length = np.full(n, 2 * np.pi / n)
    w = winding_number(np.column_stack([rho, 0 * rho]), points, normals, length)
    np.testing.assert_allclose(w, 1 / (1 - rho**n), rtol=1e-12)
    outside = np.array([1.3, 2.0, 10.0])
    w = winding_number(np.column_stack([outside, 0 * outside]), points, normals, length)
    np.testing.assert_allclose(w, 1 / (1 - outside**n), atol=1e-14)


def test_sphere_is_one_inside_and_zero_outside() -> None:
    points, normals = sphere(3000)
    A = np.full(3000, 4 * np.pi / 3000)
    directions = sphere(50)[0]
    np.testing.assert_allclose(winding_number(0.8 * directions, points, normals, A), 1.0, atol=1e-3)
    np.testing.assert_allclose(winding_number(1.2 * directions, points, normals, A), 0.0, atol=1e-3)


def test_open_square_gives_its_solid_angle() -> None:
    """A unit square seen from height h on its axis fills 4 asin(1 / (1 + 4h²))."""
    square = grid(60)
    up = np.tile([0.0, 0.0, 1.0], (3600, 1))
    height = np.array([0.2, 0.5, 2.0])
    below = np.column_stack([0 * height, 0 * height, -height])
    expected = 4 * np.arcsin(1 / (1 + 4 * height**2)) / (4 * np.pi)
    A = np.full(3600, 1 / 3600)
    np.testing.assert_allclose(winding_number(below, square, up, A), expected, rtol=1e-3)
    np.testing.assert_allclose(winding_number(-below, square, up, A), -expected, rtol=1e-3)


@settings(deadline=None, max_examples=30)
@given(st.floats(0, 6.28), st.floats(-3, 3), st.floats(-3, 3))
def test_rigid_motion_and_scale_change_nothing(angle: float, power: float, shift: float) -> None:
    points, normals = circle(60)
    A, queries = areas(points), np.random.default_rng(0).uniform(-2, 2, (30, 2))
    R = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    scale = 10.0**power
    moved = winding_number(scale * (queries @ R + shift), scale * (points @ R + shift), normals @ R, scale * A)
    np.testing.assert_allclose(moved, winding_number(queries, points, normals, A), atol=1e-9)


def test_distance_from_the_origin_costs_no_more_digits_than_the_coordinates_lose() -> None:
    points, normals = circle(200)
    A, far = areas(points), np.array([1e6, -1e6])
    near = winding_number(0.99 * points, points, normals, A)
    np.testing.assert_allclose(winding_number(0.99 * points + far, points + far, normals, A), near, atol=1e-6)


def test_shapes_add() -> None:
    (p, n), (q, m) = circle(80), circle(80, 1.0, (0.5, 0.0))
    both = winding_number(
        np.array([[0.25, 0.0], [-0.7, 0.0]]), np.vstack([p, q]), np.vstack([n, m]), np.full(160, np.pi / 40)
    )
    np.testing.assert_allclose(both, [2.0, 1.0], atol=1e-5)


def test_is_finite_at_the_points_themselves_and_at_coinciding_ones() -> None:
    points, normals = sphere(300)
    w = winding_number(points, points, normals, areas(points))
    np.testing.assert_allclose(w, 0.5, atol=0.1)
    piled = np.repeat([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], 20, axis=0)  # of area 0, and at distance 0 without rounding
    assert np.isfinite(winding_number(piled, piled, piled, areas(piled))).all()


def test_memory_does_not_grow_with_the_product_of_queries_and_points() -> None:
    points, normals = sphere(4000)
    A = areas(points)
    tracemalloc.start()
    winding_number(points, points, normals, A)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4000 * 4000 * 8 / 20


@pytest.mark.parametrize("n", [60, 3000])
def test_self_check_tells_outward_from_inward(n: int) -> None:
    for points, normals in (circle(n), sphere(n)):
        assert self_check(points, normals) == 1.0
        assert self_check(points, -normals) == 0.0


def test_self_check_sees_scattered_wrong_signs() -> None:
    points, normals = sphere(3000)
    sign = np.where(np.random.default_rng(1).random(3000) < 0.2, -1.0, 1.0)
    assert self_check(points, sign[:, None] * normals) == pytest.approx(0.8, abs=0.08)


def test_self_check_is_deterministic_and_independent_of_scale() -> None:
    points, normals = sphere(25_000)
    tilted = normals * np.where(np.random.default_rng(2).random(25_000) < 0.1, -1.0, 1.0)[:, None]
    first = self_check(points, tilted)
    assert first == self_check(points, tilted)
    assert first == pytest.approx(self_check(1000 * points + 5000, tilted), abs=0.005)


def test_self_check_of_a_plane_warns_that_there_is_no_inside() -> None:
    assert self_check(grid(20), np.tile([0.0, 0.0, 1.0], (400, 1))) < 0.9
