"""A zero set's two halves: marching through a grid, and polishing what comes out."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from ipcore.zero_set.extraction import extract
from ipcore.zero_set.newton import polish
from zero_sets import bumpy

LINES = 96
LINE = np.linspace(-1.5, 1.5, LINES)
SPACING = float(LINE[1] - LINE[0])


def test_marching(benchmark: BenchmarkFixture) -> None:
    p = bumpy(3)
    values = p.on_grid([LINE] * 3)
    mesh = benchmark(extract, values, [LINE] * 3)
    edges = np.sort(np.concatenate([mesh.cells[:, [0, 1]], mesh.cells[:, [1, 2]], mesh.cells[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()  # closed
    assert np.abs(p.distance(mesh.vertices)).max() < SPACING  # on edges that f = 0 crosses


def test_polishing(benchmark: BenchmarkFixture) -> None:
    p = bumpy(3)
    mesh = extract(p.on_grid([LINE] * 3), [LINE] * 3)
    polished = benchmark(polish, mesh, p, p.bounds, SPACING)
    # what `ipcore.zero_set.newton` says of its steps, at this degree and on this grid
    distance = np.abs(p.distance(polished.vertices))
    assert np.median(distance) < 1e-15
    assert distance.max() < 1e-13
