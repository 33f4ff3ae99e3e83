"""What is proved of shapes that are known, and that nothing false is proved of polynomials made to deceive."""

import os
from collections.abc import Callable

import numpy as np
import pytest

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.proof.prover import MOST_UNCLEARED, prove
from tests.ipcore.proof.deceivers import ball, deceivers, times

CLOSED = [shapes.circle, shapes.ellipse, shapes.superellipse, *shapes.SURFACES]


def turned(angle: float) -> FloatArray:
    """Return the rotation of the plane, or of the first two axes of space."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("make", CLOSED, ids=lambda make: make.__name__)
@pytest.mark.parametrize("basis", list(Basis))
def test_known_shapes(make: Callable[[], shapes.Shape], basis: Basis) -> None:
    shape = make()
    p = shape.polynomial if basis is Basis.MONOMIAL else shape.polynomial.to_chebyshev()
    points, _ = shape.sample(1500)
    found = prove(p, points)
    assert (found.holds, found.regular, found.components, found.euler) == (True, True, 1, shape.euler)
    assert found.uncleared == ()
    assert 0.0 < found.within < 0.5
    assert found.boxes > 8**p.dimension
    assert found.seconds > 0.0


def test_an_open_curve_reaches_the_walls() -> None:
    line = ImplicitPolynomial(1, np.array([0.1, -0.2, 1.0]), Frame(np.zeros(2), 1.0), np.array([[-1.0] * 2, [1.0] * 2]))
    x = np.linspace(-1.0, 1.0, 200)
    found = prove(line, np.column_stack([x, 0.2 * x - 0.1]))
    assert (found.holds, found.regular, found.components, found.euler) == (True, True, None, None)


@pytest.mark.parametrize(("radius", "components", "euler"), [(0.3, 2, 4), (0.05, 2, 4)])
def test_a_sphere_in_a_sphere_is_a_component(radius: float, components: int, euler: int) -> None:
    outer, inner = shapes.sphere().sample(1500)[0], radius * shapes.sphere().sample(300, seed=1)[0]
    p = times(shapes.sphere().polynomial, ball(np.zeros(3), radius))
    found = prove(p, np.vstack([outer, inner]))
    assert (found.holds, found.components, found.euler) == (True, components, euler)


def test_discs_that_touch_are_not_smooth() -> None:
    points, _ = shapes.circle().sample(400)
    bounds = np.array([[-1.3, -1.3], [3.3, 1.3]])
    disc = ImplicitPolynomial(2, shapes.circle().polynomial.coefficients, Frame(np.zeros(2), 1.0), bounds)
    found = prove(times(disc, ball(np.array([2.0, 0.0]), 1.0)), np.vstack([points, points + np.array([2.0, 0.0])]))
    assert (found.holds, found.regular, found.components, found.euler) == (True, False, None, None)
    assert len(found.uncleared) == 1
    np.testing.assert_allclose(found.uncleared[0].centre, [1.0, 0.0], atol=0.01)
    assert found.uncleared[0].radius < 0.05


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.timeout(0)
def test_nothing_false_is_proved(dimension: int) -> None:
    """Of more with `IPFIT_DECEIVERS=10000 make test ARGS="-k nothing_false"`: one of fifteen in space."""
    asked = int(os.environ.get("IPFIT_DECEIVERS", "130"))
    count = asked - asked // 15 if dimension == 2 else asked // 15
    shape = shapes.ellipse() if dimension == 2 else shapes.torus()
    data, _ = shape.sample(800)
    for number, p in enumerate(deceivers(shape, data, count)):
        found = prove(p, data)
        assert not found.holds, number
        assert not found.regular
        assert found.components is None
        assert 0 < len(found.uncleared) <= MOST_UNCLEARED


def test_the_place_of_a_speck_is_told() -> None:
    shape, centre = shapes.circle(), np.array([0.21, -0.34])
    found = prove(times(shape.polynomial, ball(centre, 1e-5)), shape.sample(400)[0])
    assert len(found.uncleared) == 1
    assert np.linalg.norm(np.array(found.uncleared[0].centre) - centre) < found.uncleared[0].radius < 0.05


def test_a_speck_within_the_tube_is_no_component_that_is_missed() -> None:
    shape = shapes.circle()
    data, _ = shape.sample(400)
    for radius, components in ((0.02, 2), (1e-6, None)):
        found = prove(times(shape.polynomial, ball(np.array([1.05, 0.0]), radius)), data)
        assert found.holds
        assert found.components == components


def test_no_zero_set_is_no_component() -> None:
    bounds = np.array([[-1.0, -1.0], [1.0, 1.0]])
    one = ImplicitPolynomial(1, np.array([1.0, 0.0, 0.1]), Frame(np.zeros(2), 1.0), bounds)
    found = prove(one, shapes.circle().sample(50)[0])
    assert (found.holds, found.regular, found.components, found.euler, found.within) == (True, True, 0, 0, 0.0)


def test_proofs_are_told_in_the_callers_unit() -> None:
    shape, frame = shapes.circle(), Frame(np.array([10.0, 20.0]), 5.0)
    found = prove(times(shape.polynomial, ball(np.array([0.2, 0.1]), 1e-3)), shape.sample(400)[0])
    raw = found.to_raw(frame)
    assert raw.within == pytest.approx(5.0 * found.within)
    np.testing.assert_allclose(raw.uncleared[0].centre, [11.0, 20.5], atol=0.3)
    assert raw.uncleared[0].radius == pytest.approx(5.0 * found.uncleared[0].radius)
    assert raw.boxes == found.boxes


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1])
def test_two_rings_and_their_pose(angle: float) -> None:
    circle, centre = shapes.circle(), turned(angle) @ np.array([0.55, 0.0])
    data, _ = circle.sample(500)
    found = prove(times(circle.polynomial, ball(centre, 0.3)), np.vstack([data, centre + 0.3 * data]))
    assert (found.holds, found.regular, found.components) == (True, True, 2)


def test_a_proof_in_raw_coordinates_is_that_of_the_frame() -> None:
    shape = shapes.torus()
    points, _ = shape.sample(1500)
    frame = Frame(np.array([5.0, -3.0, 2.0]), 40.0)
    local = shape.polynomial
    raw = ImplicitPolynomial(local.degree, local.coefficients, frame, frame.to_raw(local.bounds))
    one, other = prove(local, points), prove(raw, frame.to_raw(points), 40.0)
    assert (other.holds, other.components, other.euler, other.boxes) == (True, 1, 0, one.boxes)
    assert other.within == pytest.approx(40.0 * one.within)


@pytest.mark.parametrize(("reach", "scale"), [(1e78, 1.0), (2.0, 1e-100)])
def test_values_that_overflow_are_not_taken_for_positive(reach: float, scale: float) -> None:
    a = np.zeros(15)
    a[0], a[10], a[14] = -1.0, 1.0, 1.0  # x⁴ + y⁴ = 1, in units of the frame
    bounds = np.array([[-reach, -reach], [reach, reach]])
    p = ImplicitPolynomial(4, a, Frame(np.zeros(2), scale), bounds)
    found = prove(p, shapes.circle().sample(400)[0] + 3.0)
    assert (found.holds, found.components) == (False, None)


@pytest.mark.parametrize(("constant", "components"), [(1.0, 0), (0.0, None)])
def test_a_constant(constant: float, components: int | None) -> None:
    bounds = np.array([[-1.0, -1.0], [1.0, 1.0]])
    p = ImplicitPolynomial(0, np.array([constant]), Frame(np.zeros(2), 1.0), bounds)
    found = prove(p, shapes.circle().sample(50)[0])
    assert (found.holds, found.components) == (constant != 0.0, components)
