"""Turning normals outward, piece by piece."""

import numpy as np

from ipcore._typing import FloatArray, IntArray
from ipcore.points.winding import OFFSET, winding_number

NESTING_PROBES = 320  # in all, and at most 5 per piece: 0.2 s for 100,000 points


def outward_signs(
    p: FloatArray, normals: FloatArray, A: FloatArray, vectors: FloatArray, labels: IntArray
) -> FloatArray:
    """Return the signs (N,), one per piece, that turn normals out of the material.

    By the divergence theorem Σ (p − c)·(A n) is d times the volume that a piece encloses, positive if n points outward,
    for any c. `vectors` are the A n of that sum.
    """
    size = np.bincount(labels)
    centre = np.column_stack([np.bincount(labels, x) / size for x in p.T])
    volume = np.bincount(labels, ((p - centre[labels]) * vectors).sum(axis=1))
    sign = np.where(volume < 0.0, -1.0, 1.0)
    if len(size) > 1:
        sign *= _holes(p, sign[labels, None] * normals, A, labels)
    return np.asarray(sign[labels])


def _holes(p: FloatArray, normals: FloatArray, A: FloatArray, labels: IntArray) -> FloatArray:
    """Return −1 for pieces that lie in an odd number of others and 1 for the rest.

    Each piece's own winding number just outside it is 0, so what some of its points find there is the others'.
    """
    size = np.bincount(labels)
    m = int(np.clip(NESTING_PROBES // len(size), 1, 5))
    place = np.cumsum(size)[:, None] - size[:, None] + (size[:, None] * (np.arange(m) + 0.5) / m).astype(np.intp)
    some = np.argsort(labels, kind="stable")[place.ravel()]
    spacing = A[some, None] ** (1.0 / (p.shape[1] - 1))
    w = winding_number(p[some] + OFFSET * spacing * normals[some], p, normals, A)
    depth = np.maximum(np.rint(np.median(w.reshape(-1, m), axis=1)), 0.0)
    return np.where(depth % 2.0 == 1.0, -1.0, 1.0)
