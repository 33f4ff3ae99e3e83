"""Shapes that no polynomial describes."""

import numpy as np

from ipcore import shapes
from ipcore._typing import FloatArray

SHAPES = {2: shapes.superellipse, 3: shapes.genus_two}


def rough(d: int, count: int = 4000) -> tuple[FloatArray, FloatArray]:
    """Return points that no polynomial meets, and their normals."""
    points, normals = SHAPES[d]().sample(count)
    return points + np.random.default_rng(0).normal(scale=0.02, size=points.shape), normals
