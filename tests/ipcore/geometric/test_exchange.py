"""Cuts from grids and from proofs that fail."""

from collections.abc import Callable

import numpy as np
import pytest

import ipcore
from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.geometric.exchange import MOST_UNPROVED, Exchange
from ipcore.geometric.inside_outside import InsideOutside
from ipcore.polynomial.implicit import ImplicitPolynomial
from tests.ipcore.proof.deceivers import ball, times


def exchange(shape: shapes.Shape) -> tuple[Exchange, FloatArray]:
    points, normals = shape.sample(800)
    bounds = shape.polynomial.bounds
    return Exchange(InsideOutside(points, normals, bounds), bounds, points), points


def chebyshev(polynomial: ImplicitPolynomial) -> FloatArray:
    return polynomial.to_chebyshev().coefficients


@pytest.mark.parametrize("make", [shapes.ellipse, shapes.torus], ids=["ellipse", "torus"])
def test_a_good_fit_gets_no_cuts(make: Callable[[], shapes.Shape]) -> None:
    shape = make()
    checks, _ = exchange(shape)
    found, more = checks.next_cuts(shape.polynomial.degree, chebyshev(shape.polynomial))
    assert more is None
    assert (found.components, found.stray) == (1, 0.0)


@pytest.mark.parametrize("radius", [1e-3, 1e-6, 0.0])
@pytest.mark.parametrize("make", [shapes.ellipse, shapes.torus], ids=["ellipse", "torus"])
def test_a_speck_that_no_grid_shows_gets_cuts(make: Callable[[], shapes.Shape], radius: float) -> None:
    shape = make()
    checks, points = exchange(shape)
    centre = shape.polynomial.bounds[0] + 0.13
    spoilt = times(shape.polynomial, ball(centre, radius))
    found, more = checks.next_cuts(spoilt.degree, chebyshev(spoilt))
    assert found.stray == 0.0  # the grid steps over it
    assert more is not None
    assert 0 < len(more.t) <= MOST_UNPROVED + 1
    assert (more.side == 1.0).all()
    assert (more.margin > 0.0).all()
    low, high = shape.polynomial.bounds
    away = np.linalg.norm(low + (more.t + 1.0) / 2.0 * (high - low) - centre, axis=1)
    assert away.max() < 0.1
    assert np.linalg.norm(points - centre, axis=1).min() > 0.2


def test_an_open_scan_is_not_driven_to_high_degrees_for_want_of_a_proof() -> None:
    points, normals = shapes.sphere().sample(3000)
    seen = points[:, 0] > 0.0
    result = ipcore.fit(points[seen], normals[seen])
    assert result.proof is not None
    assert (result.diagnostics.quiet, result.proof.holds) == (False, False)
    assert result.proof.uncleared
    assert result.degree <= 3
