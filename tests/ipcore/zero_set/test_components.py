"""Zero sets whose number of components is known, on grids that break them."""

import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.survey import straying
from ipcore.zero_set.zero_set import zero_set
from tests.ipcore.zero_set.quadrics import quadric, turn_by, turned

BOX = np.array([[-2.0, -2.0], [2.0, 2.0]])


def polynomial(terms: dict[tuple[int, ...], float], box: FloatArray) -> ImplicitPolynomial:
    d, n = box.shape[1], max(sum(powers) for powers in terms)
    a = np.array([terms.get(tuple(row), 0.0) for row in graded.exponents(d, n).tolist()])
    return ImplicitPolynomial(n, a, Frame(np.zeros(d), 1.0), box)


def dumbbell(neck: float, dimension: int = 2) -> ImplicitPolynomial:
    """Return a lemniscate-like figure: two lobes at x = ±1, joined by a neck of this half width if it is positive.

    f = x⁴ − 2x² + y² [+ z²] − neck²; at x = 0 it vanishes at |y| = neck. With −c instead, the lobes are apart.
    """
    zero = (0,) * (dimension - 1)
    terms = {(4, *zero): 1.0, (2, *zero): -2.0, (0, *zero): -neck * abs(neck)}
    for axis in range(1, dimension):
        terms[tuple(2 if k == axis else 0 for k in range(dimension))] = 1.0
    return polynomial(terms, np.array([[-2.0] * dimension, [2.0] * dimension]))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("neck", "components"), [(0.1, 1), (0.01, 1), (3e-3, 1), (1e-3, 1), (-0.2, 2), (-0.5, 2)])
@pytest.mark.parametrize("resolution", [48, 61])
def test_a_thin_neck_joins_two_lobes(dimension: int, neck: float, components: int, resolution: int) -> None:
    p = dumbbell(neck, dimension)
    assert zero_set(p, resolution=resolution).components == components


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("neck", "components"), [(0.1, 1), (0.01, 1), (1e-3, 1), (-0.1, 2), (-0.3, 2)])
def test_a_report_counts_a_shape_with_a_thin_neck_once(dimension: int, neck: float, components: int) -> None:
    p = dumbbell(neck, dimension)
    points = zero_set(p, cap=False).vertices[::7]
    assert straying(p, points) == (0.0, components)


@pytest.mark.parametrize("axes", [(100.0, 1.0), (500.0, 1.0), (20.0, 1.0, 1.0), (50.0, 1.0, 1.0), (30.0, 30.0, 1.0)])
@pytest.mark.parametrize("seed", [None, 0, 1, 3])
def test_a_report_counts_a_thin_shape_once(axes: tuple[float, ...], seed: int | None) -> None:
    assert straying(*quadric(axes, seed)) == (0.0, 1)


@pytest.mark.parametrize("axes", [(50.0, 1.0), (100.0, 1.0), (20.0, 1.0, 1.0)])
@pytest.mark.parametrize("seed", [0, 2, 5])
def test_a_needle_in_pieces_is_one_component(axes: tuple[float, ...], seed: int) -> None:
    z = zero_set(quadric(axes, seed)[0], resolution=200 if len(axes) == 2 else 60)
    assert len(axes) == 3 or z.vertex_components().max() > 0
    assert z.components == 1


@pytest.mark.parametrize("apart", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("dimension", [2, 3])
def test_parts_that_are_near_each_other_stay_apart(apart: float, dimension: int) -> None:
    """Two parallel lines or planes, x² = (apart/2)²."""
    box = np.array([[-2.0] * dimension, [2.0] * dimension])
    terms = {(2, *(0,) * (dimension - 1)): 1.0, (0,) * dimension: -((apart / 2.0) ** 2)}
    assert zero_set(polynomial(terms, box), resolution=40 if apart > 0.1 else None, cap=False).components == 2


def test_no_zero_set_has_no_components_and_no_stray_share() -> None:
    for value in (1.0, -1.0):
        assert straying(polynomial({(0, 0): value}, BOX), np.eye(2)) == (None, 0)
        assert straying(polynomial({(0, 0): value, (2, 0): value, (0, 2): value}, BOX), np.eye(2)) == (None, 0)


@pytest.mark.parametrize("degrees", [5, 10, 40, 81, 85])
@pytest.mark.parametrize("axes", [(500.0, 1.0), (300.0, 1.0), (100.0, 1.0)])
def test_a_needle_of_any_direction_is_one_component(axes: tuple[float, float], degrees: float) -> None:
    p, points = turned(axes, turn_by(np.radians(degrees)))
    assert zero_set(p, data=points).components == 1
    assert straying(p, points) == (0.0, 1)
