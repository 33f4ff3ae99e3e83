"""Normals from the points alone, and on which side of the surface a place lies."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

import ipcore
from ipcore.points.winding import areas, winding_number
from sets import FloatArray

PLACES = 1000


def test_normals(benchmark: BenchmarkFixture, torus: tuple[FloatArray, FloatArray]) -> None:
    points, true = torus
    cosine = (benchmark(ipcore.estimate_normals, points) * true).sum(axis=1)
    assert (cosine > 0.0).all()
    assert cosine.mean() > 0.99


def test_winding_number(benchmark: BenchmarkFixture, torus: tuple[FloatArray, FloatArray]) -> None:
    points, normals = torus
    places = np.random.default_rng(1).uniform(-1.5, 1.5, (PLACES, 3)) * [1.0, 1.0, 0.4]
    inward = 0.4 - np.hypot(np.hypot(places[:, 0], places[:, 1]) - 1.0, places[:, 2])  # depth below the surface
    w = benchmark(winding_number, places, points, normals, areas(points))
    clear = np.abs(inward) > 0.1  # some four times the points' spacing
    assert ((w > 0.5) == (inward > 0.0))[clear].all()
