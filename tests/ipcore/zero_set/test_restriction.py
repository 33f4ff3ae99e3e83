"""Components of zero sets, what is stray of them, and what a restriction to the data keeps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ipcore import shapes
from ipcore.polynomial.frame import Frame
from ipcore.zero_set.support import SUPPORT_RADII, support_radius
from ipcore.zero_set.zero_set import zero_set
from tests.ipcore.zero_set.measures import (
    CIRCLE,
    SPHERE,
    SQUARE,
    on_wall,
    polynomial,
    product,
    ring,
    size,
    watertight,
)


@pytest.mark.parametrize(("drop", "components"), [(0.0, 2), (0.5, 1)])
def test_components_of_two_circles(drop: float, components: int) -> None:
    left, right = (
        polynomial({(0, 0): 1.25**2 - 1, (1, 0): sign * 2.5, (2, 0): 1, (0, 2): 1}, SQUARE) for sign in (1, -1)
    )
    both = product(left, right, 1.5 * SQUARE)
    both.coefficients[0] -= drop  # at the origin, half way, the product is 0.5625² = 0.316
    assert zero_set(both).components == components


def test_vertices_of_two_circles_lie_in_two_components_and_a_vertex_of_no_cell_in_its_own() -> None:
    left, right = (polynomial({(0, 0): 1.25**2 - 1, (1, 0): s * 2.5, (2, 0): 1, (0, 2): 1}, SQUARE) for s in (1, -1))
    z = zero_set(product(left, right, 1.5 * SQUARE))
    component = z.vertex_components()
    east = z.vertices[:, 0] > 0.0
    assert len(np.unique(component[east])) == len(np.unique(component[~east])) == 1
    assert len(np.unique(component)) == 2
    one = replace(z, cells=z.cells[east[z.cells[:, 0]]])
    assert len(np.unique(one.vertex_components())) == 1 + (~east).sum()


def test_cells_near_the_data_are_those_that_a_restricted_zero_set_keeps() -> None:
    data = ring(300, -0.5, np.pi)
    whole, part = zero_set(CIRCLE, restrict=False), zero_set(CIRCLE, data=data)
    near = whole.cells_near(data)
    assert 0 < near.sum() == len(part.cells) < len(whole.cells)
    assert np.isclose(np.linalg.norm(whole.cell_normals()[near], axis=1).sum(), size(part), rtol=1e-14)


def test_components_do_not_join_along_the_box() -> None:
    lines = polynomial({(0, 0): -1.0, (2, 0): 1.0}, SQUARE)  # x = ±1, the inside between them
    z = zero_set(lines)
    assert z.components == 2
    assert len(z.polylines()) == 1
    assert len(zero_set(lines, cap=False).polylines()) == 2


def test_stray_is_the_share_of_a_far_line() -> None:
    line = polynomial({(0, 0): -1.8, (1, 0): 1.0}, SQUARE)
    both, data = product(CIRCLE, line, SQUARE), ring(400)
    z = zero_set(both, data=data)
    assert z.stray == pytest.approx(4.0 / (4.0 + 2.0 * np.pi), rel=1e-4)
    assert z.components == 2
    (kept,) = z.polylines()
    assert (kept[0] == kept[-1]).all()
    assert size(z) == pytest.approx(2.0 * np.pi, rel=1e-4)
    everything = zero_set(both, data=data, restrict=False, cap=False)
    assert everything.stray == z.stray
    assert size(everything) == pytest.approx(4.0 + 2.0 * np.pi, rel=1e-4)


def test_restriction_to_part_of_a_circle_leaves_one_open_line_within_the_support_radius() -> None:
    data = ring(300, -0.5, np.pi)  # across the angle 0, where the extracted contour may begin
    z = zero_set(CIRCLE, data=data)
    (arc,) = z.polylines()
    radius = support_radius(data, Frame.of(data).scale)
    assert z.stray == pytest.approx(1.0 - (np.pi + 0.5 + 4.0 * np.arcsin(radius / 2.0)) / (2.0 * np.pi), abs=5e-3)
    assert (arc[0] != arc[-1]).any()
    assert len(arc) == len(z.vertices) == len(z.cells) + 1
    distance, _ = cKDTree(data).query(z.vertices[z.cells].mean(axis=1))
    assert np.max(distance) <= radius


@pytest.mark.parametrize("whole", [True, False])
def test_restriction_keeps_a_cap_only_if_its_rim_stays(whole: bool) -> None:
    bounds = np.array([[0.0, -1.5, -1.5], [1.5] * 3])
    data, _ = shapes.sphere().sample(4000)
    data = data[data[:, 0] > -0.2] if whole else data[(data[:, 0] > -0.2) & (data[:, 1] > 0.0)]
    z = zero_set(SPHERE, bounds, 48, data=data)
    assert z.stray == (0.0 if whole else pytest.approx(0.45, abs=0.05))
    assert watertight(z) == whole == on_wall(z, bounds).any()


@pytest.mark.parametrize(("count", "expected"), [(1000, SUPPORT_RADII[2]), (12, 2.5 * 2.0 * np.sin(np.pi / 12))])
def test_the_support_radius_is_a_share_of_the_mean_radius_or_some_spacings(count: int, expected: float) -> None:
    data = ring(count)
    assert support_radius(data, 1.0) == pytest.approx(expected, rel=1e-12)
    assert support_radius(37.0 * data + 1000.0, 37.0) == pytest.approx(37.0 * expected, rel=1e-12)
