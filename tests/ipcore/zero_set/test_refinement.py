"""Thin shapes at the resolution that is chosen, and at one that is too coarse."""

import time
from collections.abc import Callable

import numpy as np
import pytest

from ipcore import shapes
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.grid import DEFAULT_RESOLUTION
from ipcore.zero_set.refinement import FINEST_RESOLUTION, refined
from ipcore.zero_set.zero_set import zero_set
from tests.ipcore.zero_set.quadrics import content, exact_content, quadric

THIN = [
    (50.0, 1.0, 1.0),
    (20.0, 1.0, 1.0),
    (50.0, 50.0, 1.0),
    (30.0, 5.0, 0.5),
    (100.0, 1.0),
    (500.0, 1.0),
    (3.0, 0.01),
]


@pytest.mark.parametrize("axes", THIN)
@pytest.mark.parametrize("seed", [None, 0, 3])
def test_thin_ellipsoids_have_their_content_at_the_chosen_resolution(axes: tuple[float, ...], seed: int | None) -> None:
    p, points = quadric(axes, seed)
    z = zero_set(p, data=points)
    assert content(z) == pytest.approx(exact_content(axes), rel=0.03)
    assert DEFAULT_RESOLUTION[p.dimension] < z.resolution <= FINEST_RESOLUTION[p.dimension]
    assert z.components == 1


@pytest.mark.parametrize("axes", [(200.0, 1.0, 1.0), (100.0, 0.5, 0.5)])
def test_a_needle_of_200_to_1_has_its_volume(axes: tuple[float, ...]) -> None:
    z = zero_set(quadric(axes, 1)[0])
    assert content(z) == pytest.approx(exact_content(axes), rel=0.05)


@pytest.mark.parametrize("axes", THIN)
@pytest.mark.parametrize("seed", [None, 0, 3])
def test_who_asks_for_too_coarse_a_grid_is_told(axes: tuple[float, ...], seed: int | None) -> None:
    z = zero_set(quadric(axes, seed)[0], resolution=48)
    assert z.thin is not None
    assert z.thin > 0.8
    assert z.warning is not None
    assert "resolution 48" in z.warning
    assert z.warning.isascii()  # it is sent as a header


def test_a_needle_between_the_nodes_is_not_called_empty() -> None:
    p, _ = quadric((50.0, 1.0, 1.0))
    z = zero_set(p, resolution=64)
    assert (len(z.cells), z.components, z.thin) == (0, 0, 1.0)
    assert z.warning is not None
    assert z.warning.startswith("The grid of resolution 64 finds no zero set, but a finer one does.")


@pytest.mark.parametrize("make", [*shapes.CURVES, *shapes.SURFACES], ids=lambda make: str(make.__name__))
def test_ordinary_shapes_keep_the_default_resolution_and_do_not_warn(make: Callable[[], shapes.Shape]) -> None:
    p = make().polynomial
    z = zero_set(p)
    assert z.resolution == DEFAULT_RESOLUTION[p.dimension]
    assert z.thin is not None
    assert z.thin < 0.05
    assert z.warning is None


@pytest.mark.parametrize("width", [0.02, 0.01])
def test_a_thin_gap_between_two_shapes_is_thin_too(width: float) -> None:
    """Two half planes x < −w/2 and x > w/2 are inside: f = w²/4 − x²."""
    box = np.array([[-3.0, -3.0], [3.0, 3.0]])
    slit = ImplicitPolynomial(2, np.array([width**2 / 4.0, 0, 0, -1.0, 0, 0]), Frame(np.zeros(2), 1.0), box)
    z = zero_set(slit, cap=False)
    assert z.resolution > DEFAULT_RESOLUTION[2]
    assert np.abs(z.vertices[:, 0]) == pytest.approx(width / 2.0, rel=1e-6)
    assert z.components == 2


def test_what_is_far_from_the_data_does_not_refine_the_grid() -> None:
    """A circle, and two lines that are 1/100 apart, far from it."""
    box = np.array([[-4.0, -4.0], [4.0, 4.0]])
    x, y = [np.zeros((5, 5)) for _ in range(2)]
    x[2, 0], x[1, 0], x[0, 0] = 1.0, -6.0, 9.0 - 0.005**2  # (x − 3)² − 0.005²
    y[2, 0] = y[0, 2] = 1.0
    y[0, 0] = -1.0
    both = np.array([[sum(x[k, m] * y[i - k, j - m] for k in range(i + 1) for m in range(j + 1)) for j in range(5)]
                     for i in range(5)])  # fmt: skip
    exponents = [(i, n - i) for n in range(5) for i in range(n, -1, -1)]
    p = ImplicitPolynomial(4, np.array([both[e] for e in exponents]), Frame(np.zeros(2), 1.0), box)
    angle = np.linspace(0.0, 2.0 * np.pi, 300, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    assert np.abs(p(ring)).max() < 1e-12
    near, whole = zero_set(p, data=ring), zero_set(p, data=ring, restrict=False)
    assert (near.resolution, near.warning) == (DEFAULT_RESOLUTION[2], None)
    assert whole.resolution > near.resolution


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("value", [1.0, -1.0, 1e-3])
def test_without_a_zero_set_no_finer_grid_is_tried(dimension: int, value: float) -> None:
    box = np.array([[-1.0] * dimension, [1.0] * dimension])
    p = ImplicitPolynomial(0, np.array([value]), Frame(np.zeros(dimension), 1.0), box)
    start = time.process_time()
    assert refined(p).resolution == DEFAULT_RESOLUTION[dimension]
    assert time.process_time() - start < 2.0
