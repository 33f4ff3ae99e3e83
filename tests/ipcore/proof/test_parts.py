"""Which blocks touch each other."""

import numpy as np

from ipcore import shapes
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.proof.blocks import Blocks
from ipcore.proof.parts import Parts
from ipcore.proof.prover import clear
from ipcore.proof.restriction import first_blocks
from ipcore.proof.tube import Tube
from tests.ipcore.proof.deceivers import ball, times
from tests.ipcore.proof.exact import polynomial


def some(p: ImplicitPolynomial, parts: int, places: list[tuple[int, ...]]) -> Blocks:
    blocks = first_blocks(p, parts)
    wanted = {tuple(map(float, place)) for place in places}
    return blocks[np.array([tuple(place) in wanted for place in blocks.place.tolist()])]


def test_blocks_that_share_a_corner_are_together() -> None:
    p = polynomial(2, 2, 0)
    found = Parts.of([some(p, 8, [(0, 0), (1, 1), (4, 4), (4, 6)])], 2)
    assert len(found.radius) == 3
    assert found.part[0] == found.part[1]
    assert len(set(found.part.tolist())) == 3
    size = first_blocks(p, 8).radius
    np.testing.assert_allclose(sorted(found.radius), [size, size, 2.0 * size], rtol=1e-6)


def test_blocks_of_different_sizes_touch() -> None:
    p = polynomial(3, 2, 0)
    large, small = some(p, 4, [(1, 1, 1)]), some(p, 16, [(8, 4, 4), (8, 8, 8), (9, 9, 9), (14, 1, 1)])
    found = Parts.of([large, small], 3)
    assert len(found.radius) == 2
    assert (found.part == found.part[0]).tolist() == [True] * 4 + [False]
    away = np.linalg.norm(found.middle - found.centre[found.part], axis=1)
    assert (away < found.radius[found.part]).all()


def test_no_blocks_are_no_parts() -> None:
    found = Parts.of([], 3)
    assert found.middle.shape == (0, 3)
    assert len(found.radius) == 0


def test_specks_in_first_blocks_that_touch_are_parts_of_their_own() -> None:
    shape = shapes.ellipse()
    centres = [shape.polynomial.bounds[0] + np.array([x, 0.2]) for x in (0.2, 0.5, 0.8)]
    p = shape.polynomial
    for centre in centres:
        p = times(p, ball(centre, 1e-3))
    cleared = clear(p, Tube(shape.sample(800)[0]))
    assert cleared.hopeless
    found = Parts.of(cleared.left, 2)
    assert len(found.radius) == 3
    assert (found.radius < 0.1).all()
    for centre in centres:
        assert (np.linalg.norm(found.centre - centre, axis=1) < found.radius).any()
