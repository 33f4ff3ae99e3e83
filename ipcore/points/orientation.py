"""The orientation of normals: outward for each connected piece, and inward for the walls of holes."""

import numpy as np

from ipcore._typing import FloatArray, IntArray
from ipcore.points.winding import OFFSET, winding_number

NESTING_PROBES = (
    320  # points beside which pieces are examined: of all together, at most 5 per piece; 0.2 s for 10⁵ points
)


def outward_signs(
    p: FloatArray, normals: FloatArray, A: FloatArray, vectors: FloatArray, labels: IntArray
) -> FloatArray:
    """Return the signs (N,), the same within a piece, by which normals must be multiplied to point out of the material.

    By the divergence theorem Σ (p − c)·(A n) is d times the volume that a piece encloses, for any c, and positive if n
    points outward.

    Parameters
    ----------
    p, normals
        (N, d), the points and their unit normals, whose signs agree within each piece.
    A
        (N,), the area (3D) or length (2D) for which each point stands.
    vectors
        (N, d), the A n of the sum above.
    labels
        (N,), the number of the piece to which each point belongs, from 0.

    """
    size = np.bincount(labels)
    centre = np.column_stack([np.bincount(labels, x) / size for x in p.T])
    volume = np.bincount(labels, ((p - centre[labels]) * vectors).sum(axis=1))
    sign = np.where(volume < 0.0, -1.0, 1.0)
    if len(size) > 1:
        sign *= _holes(p, sign[labels, None] * normals, A, labels)
    return np.asarray(sign[labels])


def _holes(p: FloatArray, normals: FloatArray, A: FloatArray, labels: IntArray) -> FloatArray:
    """Return for each piece −1 if it lies inside an odd number of other pieces, else 1; the parameters are as above.

    Just outside a piece its own winding number is 0. So the winding number there, at some of its points, is the number
    of other pieces around it.
    """
    size = np.bincount(labels)
    m = int(np.clip(NESTING_PROBES // len(size), 1, 5))
    position = np.cumsum(size)[:, None] - size[:, None] + (size[:, None] * (np.arange(m) + 0.5) / m).astype(np.intp)
    some = np.argsort(labels, kind="stable")[position.ravel()]
    spacing = A[some, None] ** (1.0 / (p.shape[1] - 1))
    w = winding_number(p[some] + OFFSET * spacing * normals[some], p, normals, A)
    depth = np.maximum(np.rint(np.median(w.reshape(-1, m), axis=1)), 0.0)
    return np.where(depth % 2.0 == 1.0, -1.0, 1.0)
