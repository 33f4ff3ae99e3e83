"""How thick annuli, slabs and wedges are found to be."""

import numpy as np
import pytest

from ipcore import shapes
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.thickness import THIN_CELLS, thin_share
from tests.ipcore.zero_set.quadrics import quadric

SQUARE = np.array([[-3.0, -3.0], [3.0, 3.0]])


def slab(width: float) -> ImplicitPolynomial:
    """Return x² − width²/4, negative in a slab."""
    return ImplicitPolynomial(2, np.array([-(width**2) / 4.0, 0, 0, 1.0, 0, 0]), Frame(np.zeros(2), 1.0), SQUARE)


@pytest.mark.parametrize("width", [0.01, 0.1, 0.7])
@pytest.mark.parametrize(("cells", "expected"), [(THIN_CELLS - 0.05, 1.0), (THIN_CELLS + 0.05, 0.0)])
def test_a_slab_is_thin_below_four_cells(width: float, cells: float, expected: float) -> None:
    walls = np.column_stack([np.full(50, width / 2.0), np.linspace(-2.0, 2.0, 50)])
    assert thin_share(slab(width), walls, width / cells, SQUARE) == expected


def test_places_beside_the_zero_set_are_moved_onto_it() -> None:
    ring, normals = shapes.circle().sample(200)
    p, spacing = shapes.circle().polynomial, 0.45
    for off in (-0.2, 0.2):
        assert thin_share(p, ring + off * normals, spacing, SQUARE) == 0.0


def test_what_lies_beyond_the_bounds_does_not_count() -> None:
    walls = np.column_stack([np.full(50, 0.5), np.linspace(-2.0, 2.0, 50)])
    assert thin_share(slab(1.0), walls, 0.3, SQUARE) == 1.0
    assert thin_share(slab(1.0), walls, 0.3, np.array([[-0.05, -3.0], [3.0, 3.0]])) == 0.0


def test_only_places_near_the_data_count() -> None:
    p, points = quadric((100.0, 1.0))
    tip = points[points[:, 0] > 99.0]
    middle = points[np.abs(points[:, 0]) < 50.0]
    spacing = 0.4
    assert thin_share(p, tip, spacing, p.bounds) > 0.9
    assert thin_share(p, middle, spacing, p.bounds) == 0.0
    both = np.vstack([tip, middle])
    assert 0.0 < thin_share(p, both, spacing, p.bounds) < 0.5
    assert thin_share(p, both, spacing, p.bounds, middle) == 0.0


def test_a_place_where_the_gradient_vanishes_is_not_thin() -> None:
    assert thin_share(slab(0.0), np.zeros((5, 2)), 0.1, SQUARE) == 0.0
