"""Extracted cells against scikit-image's, and blocks against the whole."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from skimage.measure import find_contours, marching_cubes

from ipcore import shapes
from ipcore._typing import FloatArray, IntArray
from ipcore.errors import InvalidOptionsError
from ipcore.polynomial import graded
from ipcore.polynomial.bernstein import ranges
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.extraction import extract, extract_pruned
from ipcore.zero_set.marching import EDGE_MARGIN
from ipcore.zero_set.mesh import Mesh, cell_vectors
from tests.ipcore.bumps import bumpy

EPS = float(np.finfo(float).eps)
SPHERE = shapes.sphere().polynomial


def grid(bounds: FloatArray, counts: tuple[int, ...]) -> list[FloatArray]:
    return [np.linspace(low, high, n) for (low, high), n in zip(bounds.T, counts, strict=True)]


def watertight(cells: IntArray) -> bool:
    """Return whether every edge is used once in either direction, or every vertex of a curve entered and left once."""
    if cells.shape[1] == 2:
        return bool((np.unique(cells[:, 0]) == np.sort(cells[:, 1])).all())
    edges = np.concatenate([cells[:, [k, k - 2]] for k in range(3)])
    one, other = (np.unique(edges[:, way], axis=0) for way in ([0, 1], [1, 0]))
    return len(one) == len(edges) and bool((one == other).all())


def content(mesh: Mesh) -> float:
    middle = mesh.vertices[mesh.cells].mean(axis=1)
    return float((middle * cell_vectors(mesh.vertices, mesh.cells)).sum() / mesh.vertices.shape[1])


def matched(mesh: Mesh, other: Mesh) -> IntArray:
    """Return for each vertex of a mesh which of another it is, in the order of coordinates rounded far above EPS."""
    assert mesh.vertices.shape == other.vertices.shape
    ours, theirs = (np.lexsort(np.round(m.vertices, 9).T) for m in (mesh, other))
    found = np.empty_like(ours)
    found[ours] = theirs
    return found


def assert_same(mesh: Mesh, other: Mesh, tolerance: float) -> None:
    place = matched(mesh, other)
    np.testing.assert_allclose(mesh.vertices, other.vertices[place], atol=tolerance, rtol=0.0)
    assert (mesh.held == other.held[place]).all()
    ours, theirs = (
        [tuple(np.roll(c, -int(c.argmin())).tolist()) for c in cells] for cells in (place[mesh.cells], other.cells)
    )
    assert sorted(ours) == sorted(theirs)
    caps = (
        {cell for cell, cap in zip(cells, m.cap, strict=True) if cap} for cells, m in ((ours, mesh), (theirs, other))
    )
    assert next(caps) == next(caps)


@pytest.mark.parametrize("shape", [(9, 8), (7, 8, 6)])
@pytest.mark.parametrize("seed", range(10))
def test_any_values_give_a_closed_manifold_round_their_inside(shape: tuple[int, ...], seed: int) -> None:
    """Small whole numbers: zeros, ties on faces and every case, at walls, too."""
    values = np.random.default_rng(seed).integers(-2, 3, shape).astype(float)
    mesh = extract(values, grid(np.array([[0.0] * len(shape), np.array(shape) - 1.0]), shape))
    assert watertight(mesh.cells)
    assert content(mesh) > 0.0
    assert len(np.unique(mesh.cells)) == len(mesh.vertices)


def assert_cut_alike(ours: FloatArray, theirs: FloatArray) -> None:
    """Assert one to one the same vertices; scikit-image keeps no margin from the nodes, and computes in float32."""
    distance, place = cKDTree(ours).query(theirs)
    assert len(ours) == len(theirs) == len(np.unique(place))
    assert np.max(distance) < EDGE_MARGIN + 1e-4
    fraction = np.abs(theirs - np.round(theirs)).max(axis=1)
    assert np.max(np.asarray(distance)[fraction > 2 * EDGE_MARGIN]) < 1e-4


def test_surface_is_cut_where_scikit_image_cuts_it() -> None:
    p, counts = bumpy(3, 0), (41, 41, 41)
    values = p.on_grid(grid(p.bounds, counts))
    index, triangles, _, _ = marching_cubes(values.astype(np.float32), 0.0)
    ours = extract(values, grid(np.array([[0.0] * 3, [40.0] * 3]), counts))
    assert_cut_alike(ours.vertices, index)
    assert len(ours.cells) == len(triangles)


def test_curve_is_cut_where_scikit_image_cuts_it() -> None:
    p, counts = bumpy(2, 1), (60, 60)
    values = p.on_grid(grid(p.bounds, counts))
    theirs = np.concatenate([ring[:-1] for ring in find_contours(values, 0.0)])
    assert_cut_alike(extract(values, grid(np.array([[0.0] * 2, [59.0] * 2]), counts)).vertices, theirs)


CUT = np.array([[-0.9, -1.4, -1.5], [1.5, 0.7, 1.2]])  # through the bumps, so with caps


@pytest.mark.parametrize(("counts", "size"), [((40, 40, 40), 7), ((61, 50, 44), 16), ((33, 34, 35), 40)])
@pytest.mark.parametrize("seed", [0, 1])
def test_blocks_of_a_surface_join_to_the_whole(counts: tuple[int, ...], size: int, seed: int) -> None:
    p = bumpy(3, seed, height=1.0)
    axes = grid(CUT, counts)
    whole, joined = extract(p.on_grid(axes), axes), extract_pruned(p, axes, 1, size)
    assert whole.cap.any()
    assert watertight(joined.cells)
    assert_same(joined, whole, 1e-11)


@pytest.mark.parametrize("size", [5, 32, 500])
def test_blocks_of_a_curve_join_to_the_whole(size: int) -> None:
    p = bumpy(2, 0, height=0.5)
    axes = grid(CUT[:, :2], (200, 160))
    whole, joined = extract(p.on_grid(axes), axes), extract_pruned(p, axes, 1, size)
    assert whole.cap.any()
    assert watertight(joined.cells)
    assert_same(joined, whole, 1e-11)


@pytest.mark.parametrize("size", [3, 8])
def test_blocks_join_where_nodes_lie_on_the_zero_set_and_at_its_corners(size: int) -> None:
    """A cone's tip in a node between blocks, and many nodes where f is 0 but for rounding: signs must not differ."""
    cone = {(2, 0, 0): 1.0, (0, 2, 0): 1.0, (0, 0, 2): -1.0}
    a = np.zeros(graded.count(3, 2))
    a[graded.column(np.array(list(cone)))] = list(cone.values())
    for shift in (0.0, 1.0 / 3.0):
        bounds = np.array([[-1.0] * 3, [1.0] * 3]) + shift
        p = ImplicitPolynomial(2, a, Frame(np.full(3, shift), 1.0), bounds)
        mesh = extract_pruned(p, grid(bounds, (25, 25, 25)), 1, size)
        assert watertight(mesh.cells)
        assert watertight(extract_pruned(p, grid(bounds, (24, 25, 26)), 1, size).cells)


def test_threads_change_nothing() -> None:
    p = bumpy(3, 2)
    axes = grid(p.bounds, (150, 150, 150))
    one, three = (extract_pruned(p, axes, threads) for threads in (1, 3))
    for name in ("vertices", "cells", "cap", "held"):
        np.testing.assert_array_equal(getattr(one, name), getattr(three, name))


@pytest.mark.parametrize("height", [0.3, 2.0])
def test_few_blocks_remain_and_none_with_a_crossing_is_missed(height: float) -> None:
    p = bumpy(3, 0, height)
    lines = grid(p.bounds, (129, 129, 129))
    low, high = ranges(p, [np.stack([line[:-1:8], line[8::8]]) for line in lines])
    inside = p.on_grid(lines) < 0.0
    windows = np.lib.stride_tricks.sliding_window_view(inside, (9, 9, 9))[::8, ::8, ::8]
    crossed = windows.any(axis=(3, 4, 5)) & ~windows.all(axis=(3, 4, 5))
    kept = (low < 0.0) & (high >= 0.0)
    assert kept[crossed].all()
    assert kept.sum() < 1.1 * crossed.sum()


def test_overflow_is_refused() -> None:
    with pytest.raises(InvalidOptionsError, match="overflows"):
        extract_pruned(SPHERE, grid(SPHERE.bounds * 1e200, (40, 40, 40)))


@pytest.mark.parametrize(("sign", "cells"), [(1.0, 0), (-1.0, 2 * 6 * 39**2)])
def test_a_constant_has_no_cells_or_the_walls(sign: float, cells: int) -> None:
    constant = ImplicitPolynomial(0, np.array([sign]), SPHERE.frame, SPHERE.bounds)
    mesh = extract_pruned(constant, grid(SPHERE.bounds, (40, 40, 40)), 1, 9)
    assert len(mesh.cells) == cells
    assert mesh.cap.all()
    assert content(mesh) == pytest.approx(float(np.prod(np.ptp(SPHERE.bounds, axis=0))) if cells else 0.0)
