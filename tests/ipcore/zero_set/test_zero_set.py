"""The zero set against what is known of circles, spheres, tori and their products."""

from collections.abc import Callable

import numpy as np
import pytest

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.extraction import extract
from ipcore.zero_set.mesh import cell_vectors
from ipcore.zero_set.newton import polish
from ipcore.zero_set.zero_set import zero_set
from tests.ipcore.bumps import bumpy
from tests.ipcore.zero_set.measures import (
    CIRCLE,
    CUBE,
    EPS,
    SPHERE,
    SQUARE,
    TORUS,
    content,
    euler,
    moved,
    on_wall,
    polynomial,
    rates,
    size,
    watertight,
)


@pytest.mark.parametrize("shape", [*shapes.CURVES, *shapes.SURFACES])
def test_vertices_lie_on_the_zero_set_and_cells_close_and_face_outward(shape: Callable[[], shapes.Shape]) -> None:
    p = shape().polynomial
    z = zero_set(p, resolution=64)
    assert np.abs(p.distance(z.vertices)).max() < 1e-13
    assert p.contains(z.vertices).all()
    assert z.components == 1
    assert watertight(z)
    assert content(z) > 0.0
    assert np.abs(np.linalg.norm(z.normals, axis=1) - 1.0).max() < 4 * EPS
    if z.dimension == 3:
        assert euler(z) == shape().euler


def test_length_converges_at_rate_2() -> None:
    assert min(rates([2 * np.pi - size(zero_set(CIRCLE, resolution=n)) for n in (17, 33, 65, 129)])) > 1.9


@pytest.mark.parametrize(
    ("p", "area", "volume"), [(SPHERE, 4 * np.pi, 4 / 3 * np.pi), (TORUS, 4 * np.pi**2 * 0.4, 2 * np.pi**2 * 0.16)]
)
def test_area_and_volume_converge_at_rate_2(p: ImplicitPolynomial, area: float, volume: float) -> None:
    meshes = [zero_set(p, resolution=n) for n in (17, 33, 65, 129)]
    assert min(rates([area - size(z) for z in meshes])) > 1.8
    assert min(rates([volume - content(z) for z in meshes])) > 1.8


@pytest.mark.parametrize(("p", "bounds"), [(CIRCLE, SQUARE), (SPHERE, np.array([[-2.0] * 3, [2.0] * 3]))])
def test_nodes_on_the_zero_set_collapse_no_cell(p: ImplicitPolynomial, bounds: FloatArray) -> None:
    z = zero_set(p, bounds, resolution=9)  # grid lines at multiples of 0.5, with nodes (±1, 0, 0) and so on
    assert watertight(z)
    assert z.dimension == 2 or euler(z) == 2
    assert np.linalg.norm(z.cell_normals(), axis=1).min() > 0.0


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_newton_steps_flip_nothing(dimension: int, seed: int) -> None:
    p = bumpy(dimension, seed)
    z = zero_set(p, resolution=48, cap=False)
    vectors = z.cell_normals()
    spacing = float((p.bounds[1] - p.bounds[0]).max()) / 47
    weighty = np.linalg.norm(vectors, axis=1) > 1e-3 * spacing ** (dimension - 1)
    along = (vectors * z.normals[z.cells].mean(axis=1)).sum(axis=1)
    assert (along[weighty] > 0.0).all()
    assert np.abs(p.distance(z.vertices)).max() < 1e-7  # the sharpest bump; at the default resolution it is 1e-14


@pytest.mark.parametrize("seed", range(4))
def test_newton_steps_flip_nothing_where_the_grid_is_far_too_coarse(seed: int) -> None:
    p = bumpy(3, seed, height=2.0)
    axes = [np.linspace(low, high, 24) for low, high in p.bounds.T]
    rough = extract(p.on_grid(axes), axes)
    smooth = polish(rough, p, p.bounds, float(axes[0][1] - axes[0][0]))
    before, after = cell_vectors(rough.vertices, rough.cells), cell_vectors(smooth.vertices, smooth.cells)
    held = rough.held.all(axis=1)
    assert (smooth.vertices[held] == rough.vertices[held]).all()
    assert ((before * after).sum(axis=1) >= 0.0).mean() > 0.999  # each of the steps flips none; together, a sliver may
    stuck = np.abs(p.distance(smooth.vertices[~held])) > 1e-3
    assert stuck.mean() < 0.02


def test_singular_points_keep_vertices_within_half_a_cell() -> None:
    cone = polynomial({(2, 0, 0): 1.0, (0, 2, 0): 1.0, (0, 0, 2): -1.0}, CUBE)
    z = zero_set(cone, resolution=31)
    assert np.isfinite(z.vertices).all()
    assert watertight(z)
    assert (
        np.abs(np.hypot(z.vertices[:, 0], z.vertices[:, 1]) - np.abs(z.vertices[:, 2]))[
            ~np.isin(np.arange(len(z.vertices)), z.cells[on_wall(z, CUBE)])
        ].max()
        < 0.05
    )


@pytest.mark.parametrize("corner", [(0.0, -1.5, -1.5), (0.0, 0.0, -1.5), (0.0, 0.0, 0.0)])
def test_a_box_that_cuts_the_ball_gets_caps(corner: tuple[float, ...]) -> None:
    bounds = np.array([corner, (1.5,) * 3])
    cuts = sum(x == 0.0 for x in corner)
    z = zero_set(SPHERE, bounds, resolution=65)
    assert watertight(z)
    assert euler(z) == 2
    assert content(z) == pytest.approx(4 / 3 * np.pi / 2**cuts, rel=2e-3)
    cap = on_wall(z, bounds)
    areas = np.linalg.norm(z.cell_normals(), axis=1)
    assert areas[cap].sum() == pytest.approx(cuts * np.pi / 2 ** (cuts - 1), rel=2e-3)
    assert areas[~cap].sum() == pytest.approx(4 * np.pi / 2**cuts, rel=2e-3)
    assert z.components == 1
    inner = np.setdiff1d(z.cells[cap], z.cells[~cap])  # a wall's normal within the cap, ∇f's along its rim
    assert ((z.normals[inner] == 0.0) | (z.vertices[inner] == 0.0)).all()
    assert (z.normals[inner].sum(axis=1) < -1.0 + 4 * EPS).all()


def test_without_caps_the_surface_stays_open_and_its_rim_on_the_wall() -> None:
    bounds = np.array([[0.0, -1.5, -1.5], [1.5] * 3])
    z = zero_set(SPHERE, bounds, resolution=33, cap=False)
    assert not watertight(z)
    assert not on_wall(z, bounds).any()
    rim = z.vertices[z.vertices[:, 0] == 0.0]
    assert len(rim) > 40
    assert np.abs(np.linalg.norm(rim, axis=1) - 1.0).max() < 1e-12


def test_a_box_that_cuts_the_disc_gets_caps_around_its_corner() -> None:
    bounds = np.array([[0.0, 0.0], [1.5, 1.5]])
    z = zero_set(CIRCLE, bounds)
    (outline,) = z.polylines()
    assert (outline[0] == outline[-1]).all()
    assert content(z) == pytest.approx(np.pi / 4, rel=1e-4)
    assert size(z) == pytest.approx(np.pi / 2 + 2.0, rel=1e-4)
    (arc,) = zero_set(CIRCLE, bounds, cap=False).polylines()
    assert np.abs(arc[[0, -1]] - [[1.0, 0.0], [0.0, 1.0]]).max() < 1e-12


@pytest.mark.parametrize(("p", "bounds"), [(CIRCLE, SQUARE), (SPHERE, CUBE)])
def test_the_outside_of_a_ball_is_the_box_with_a_hole(p: ImplicitPolynomial, bounds: FloatArray) -> None:
    outside = ImplicitPolynomial(p.degree, -p.coefficients, p.frame, bounds)
    whole, bare = zero_set(outside), zero_set(outside, cap=False)
    box = float(np.prod(bounds[1] - bounds[0]))
    assert watertight(whole)
    assert content(whole) == pytest.approx(box + content(bare))
    assert content(bare) == pytest.approx(-content(zero_set(p, bounds)), rel=1e-4)
    assert whole.components == bare.components == 1


def test_polylines_have_the_inside_on_their_left() -> None:
    annulus = polynomial({(0, 0): 0.25, (2, 0): -1.25, (0, 2): -1.25, (4, 0): 1, (2, 2): 2, (0, 4): 1}, SQUARE)
    areas = []
    for line in zero_set(annulus).polylines():
        assert (line[0] == line[-1]).all()
        left = (line[:-1] + line[1:]) / 2 + 0.1 * np.diff(line, axis=0) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        assert (annulus(left) < 0.0).all()
        x, y = line.T
        areas.append(float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) / 2)
    assert sorted(areas) == pytest.approx([-np.pi / 4, np.pi], rel=1e-3)


@pytest.mark.parametrize("p", [CIRCLE, TORUS, shapes.genus_two().polynomial])
def test_shift_and_scale_move_the_zero_set_along(p: ImplicitPolynomial) -> None:
    data = zero_set(p, resolution=20).vertices[::3]
    here = zero_set(p, resolution=40, data=data)
    there = zero_set(moved(p, 1000.0, 37.0), resolution=40, data=37.0 * data + 1000.0)
    assert (there.cells == here.cells).all()
    assert np.abs(there.vertices - (37.0 * here.vertices + 1000.0)).max() < 1e-8
    assert np.abs(there.normals - here.normals).max() < 1e-9
    assert there.components == here.components
    assert there.stray == pytest.approx(here.stray, abs=1e-12)


def test_cells_are_near_cubic_in_an_oblong_box() -> None:
    bounds = np.array([[-0.5, -2.0], [0.5, 2.0]])
    line = polynomial({(1, 0): 1.0, (0, 1): 0.1}, bounds)
    lengths = np.linalg.norm(np.diff(zero_set(line, resolution=81, cap=False).polylines()[0], axis=0), axis=1)
    assert lengths.max() < 1.2 * 4.0 / 80
    assert len(lengths) >= 80


@pytest.mark.parametrize("value", [1.0, -1.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_no_zero_set_is_empty_and_neither_stray_nor_thin(dimension: int, value: float) -> None:
    bounds = np.array([[-1.0] * dimension, [1.0] * dimension])
    constant = polynomial({(0,) * dimension: value}, bounds)
    z = zero_set(constant, data=np.eye(dimension))
    assert (z.vertices.shape, z.cells.shape, z.normals.shape) == ((0, dimension),) * 3
    assert (z.components, z.stray, z.thin, z.warning) == (0, None, None, None)
    assert zero_set(constant).stray is None
    assert dimension == 3 or z.polylines() == []


@pytest.mark.parametrize("huge", [1e-100, 1e100])
def test_the_size_of_the_coefficients_does_not_matter(huge: float) -> None:
    scaled = ImplicitPolynomial(SPHERE.degree, huge * SPHERE.coefficients, SPHERE.frame, SPHERE.bounds)
    assert size(zero_set(scaled, resolution=24)) == pytest.approx(size(zero_set(SPHERE, resolution=24)), rel=1e-12)


@pytest.mark.parametrize(
    ("bounds", "resolution"),
    [
        (np.zeros((2, 3)), 16),
        (CUBE[::-1], 16),
        (CUBE[:, :2], 16),
        (CUBE * np.inf, 16),
        (CUBE * 1e200, 16),
        (CUBE, 3),
        (CUBE, -1),
    ],
)
def test_nonsense_is_refused(bounds: FloatArray, resolution: int) -> None:
    with pytest.raises(InvalidOptionsError):
        zero_set(SPHERE, bounds, resolution)


@pytest.mark.parametrize("data", [np.zeros((5, 2)), np.zeros((1, 3)), np.full((4, 3), np.nan), np.zeros(3)])
def test_unusable_data_are_refused(data: FloatArray) -> None:
    with pytest.raises(InvalidPointsError):
        zero_set(SPHERE, resolution=8, data=data)


def test_a_surface_has_no_polylines() -> None:
    with pytest.raises(InvalidOptionsError):
        zero_set(SPHERE, resolution=8).polylines()
