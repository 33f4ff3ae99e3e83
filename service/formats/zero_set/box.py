"""The box of a zero set."""

import numpy as np

import ipcore


def corners(vertices: ipcore.FloatArray) -> tuple[ipcore.FloatArray, ipcore.FloatArray]:
    """Return the lower and the upper corner (d,) of the box of vertices (V, d); the origin if there are none."""
    origin = np.zeros(vertices.shape[1])
    return (vertices.min(axis=0), vertices.max(axis=0)) if len(vertices) else (origin, origin)
