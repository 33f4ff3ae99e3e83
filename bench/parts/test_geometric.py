"""One iteration of the geometric fit: evaluation, normal equations, step."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from ipcore import shapes
from ipcore.geometric.levenberg_marquardt import Effort, Refined, refine
from ipcore.geometric.objective import DataTables, Objective
from ipcore.polynomial import graded
from sets import FloatArray

DEGREE, ANGLE = 8, 0.001


def test_one_iteration(benchmark: BenchmarkFixture, torus: tuple[FloatArray, FloatArray]) -> None:
    points, normals = torus
    true = shapes.torus().polynomial.to_chebyshev()
    data = DataTables(points, normals, np.ones(len(points)), true.bounds)
    objective = Objective(data, DEGREE, [], ANGLE)
    a = np.zeros(graded.count(3, DEGREE))
    a[: len(true.coefficients)] = true.coefficients
    a += 1e-3 * np.abs(a).max() * np.random.default_rng(0).normal(size=len(a)) / (1.0 + np.arange(len(a)))

    def work() -> Refined:
        return refine(objective, a, Effort(steps=1, tolerance=0.0, patience=2))

    fit = benchmark(work)
    assert fit.steps == 1
    assert fit.evaluation.value < 0.1 * objective.evaluate(a).value  # Gauss–Newton near an exact shape
