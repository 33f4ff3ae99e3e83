"""Fixtures of the timed parts: one thread, as in a worker, and points on a torus, whose normals are known exactly."""

import os

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy is loaded

import numpy as np
import pytest

from sets import FloatArray

RADIUS = 0.4  # of the torus's tube; the circle in its middle has 1


@pytest.fixture
def torus() -> tuple[FloatArray, FloatArray]:
    """Return 10,000 random points of a torus and their outward normals, (N, 3) each."""
    u, v = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (2, 10_000))
    normals = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    return np.column_stack([np.cos(u), np.sin(u), 0.0 * u]) + RADIUS * normals, normals
