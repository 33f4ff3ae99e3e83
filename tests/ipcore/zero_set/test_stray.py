"""The rule for stray parts: gaps of a sample are none, sheets, bulges and specks are."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from ipcore import shapes
from ipcore._typing import FloatArray, IntArray
from ipcore.polynomial.frame import Frame
from ipcore.zero_set.stray import stray_cells, stray_share
from ipcore.zero_set.support import gap_radius, support_radius
from ipcore.zero_set.survey import straying
from ipcore.zero_set.zero_set import ZeroSet, zero_set
from tests.ipcore.zero_set.quadrics import quadric, random_sample

CLOSED = [make for make in (*shapes.CURVES, *shapes.SURFACES) if make is not shapes.cubic]
Make = Callable[[], shapes.Shape]


@cache
def fine(make: Make) -> ZeroSet:
    return zero_set(make().polynomial, cap=False)


def ring(radius: float, start: float = 0.0, end: float = 2.0 * np.pi, count: int = 720) -> tuple[FloatArray, IntArray]:
    """Return the vertices and the segments of an arc about the origin."""
    angle = np.linspace(start, end, count)
    around = np.arange(count - 1)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]), np.column_stack([around, around + 1])


@pytest.mark.parametrize("make", CLOSED, ids=lambda make: str(make.__name__))
@pytest.mark.parametrize("count", [100, 300, 1000, 3000])
def test_random_samples_of_closed_shapes_have_nothing_stray_and_meshes_leave_nothing_out(
    make: Make, count: int
) -> None:
    p, whole = make().polynomial, fine(make)
    for seed in range(5):
        points = random_sample(whole, count, seed)
        assert straying(p, points) == (0.0, whole.components)
        kept = zero_set(p, data=points)
        assert kept.stray == 0.0
        assert len(kept.cells) == len(whole.cells)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("axes", [(50.0, 1.0), (10.0, 1.0, 1.0), (10.0, 10.0, 1.0)])
@pytest.mark.parametrize("count", [300, 1000])
def test_random_samples_of_thin_shapes_have_nothing_stray(axes: tuple[float, ...], count: int, seed: int) -> None:
    p, _ = quadric(axes, seed)
    points = random_sample(zero_set(p), count, seed)
    assert straying(p, points)[0] == 0.0
    assert zero_set(p, data=points).stray == 0.0


@pytest.mark.parametrize("make", CLOSED, ids=lambda make: str(make.__name__))
def test_of_an_open_scan_the_other_side_is_stray_and_left_out(make: Make) -> None:
    p, whole = make().polynomial, fine(make)
    points = random_sample(whole, 2000, 0)
    points = points[points[:, 0] > np.median(points[:, 0])]
    stray, _ = straying(p, points)
    assert stray is not None
    assert 0.15 < stray < 0.5
    part = zero_set(p, data=points, cap=False)
    assert part.stray is not None
    assert part.stray == pytest.approx(stray, abs=0.01)
    area = [np.linalg.norm(z.cell_normals(), axis=1).sum() for z in (part, whole)]
    assert area[0] / area[1] == pytest.approx(1.0 - part.stray, abs=1e-9)


@pytest.mark.parametrize("length", [0.01, 0.05, 0.3])
def test_a_stray_component_of_any_size_is_found(length: float) -> None:
    """An arc of length 2π · 0.001 … 0.05 at the distance 0.2 from a circle of data."""
    data, around = ring(1.0)
    speck, line = ring(1.2, 0.0, length, 9)
    vertices, cells = np.vstack([data, speck]), np.vstack([around, len(data) + line])
    assert support_radius(data, Frame.of(data).scale) < 0.2
    stray = stray_cells(vertices, cells, data)
    assert stray.tolist() == [False] * len(around) + [True] * len(line)
    assert stray_share(vertices, cells, stray) == pytest.approx(1.2 * length / (2.0 * np.pi + 1.2 * length), rel=1e-3)


def sparse(count: int, seed: int = 0) -> FloatArray:
    """Return random points on the unit circle: a sample with a gap radius that is larger than the support radius."""
    angle = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, count)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def test_a_speck_within_the_gap_radius_is_stray_though_a_gap_is_not() -> None:
    data = sparse(60)
    support, gap = support_radius(data, Frame.of(data).scale), gap_radius(data)
    assert support < 0.2 < gap
    circle, around = ring(1.0)
    speck, line = ring(1.2, 0.0, 0.1, 9)
    stray = stray_cells(np.vstack([circle, speck]), np.vstack([around, len(circle) + line]), data)
    assert not stray[: len(around)].any()
    assert stray[len(around) :].all()


@pytest.mark.parametrize("height", [0.2, 0.25, 0.3])
def test_a_bulge_over_data_is_stray_within_the_gap_radius(height: float) -> None:
    """The zero set leaves the circle where there are data, and comes back."""
    data = sparse(60)
    assert support_radius(data, Frame.of(data).scale) < height < gap_radius(data)
    circle, around = ring(1.0)
    angle = np.arctan2(*circle.T[::-1]) - 1.0
    bulged = circle * (1.0 + height * (1.0 + np.tanh((0.5 - np.abs(angle)) / 0.03)) / 2.0)[:, None]
    stray = stray_cells(bulged, around, data)
    middle = np.abs(angle[:-1]) < 0.3
    assert stray[middle].all()
    assert not stray[np.abs(angle[:-1]) > 0.7].any()


def test_the_end_of_a_curve_beyond_the_data_is_stray_from_the_support_radius_on() -> None:
    data, _ = ring(1.0, 0.0, 2.0, 200)
    circle, around = ring(1.0)
    radius = support_radius(data, Frame.of(data).scale)
    distance = np.linalg.norm((circle[1:] + circle[:-1])[:, None] / 2.0 - data, axis=2).min(axis=1)
    np.testing.assert_array_equal(stray_cells(circle, around, data), distance > radius)


def test_repeated_data_change_nothing() -> None:
    p, points = shapes.torus().polynomial, random_sample(fine(shapes.torus), 400, 1)
    copies = np.repeat(points, 5, axis=0)
    assert straying(p, copies) == straying(p, points) == (0.0, 1)
    assert len(zero_set(p, data=copies).cells) == len(zero_set(p, data=points).cells)


def test_nothing_has_no_stray_share() -> None:
    none, cells = np.empty((0, 3)), np.empty((0, 3), dtype=np.intp)
    stray = stray_cells(none, cells, np.eye(3))
    assert stray.tolist() == []
    assert stray_share(none, cells, stray) is None
