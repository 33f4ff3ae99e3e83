"""The nearest of many points, asked for on as many threads as pay."""

import numpy as np
from scipy.spatial import cKDTree

from ipcore._threads import available
from ipcore._typing import FloatArray, IntArray

# Places that one thread sees to alone. It takes some 2 ms; to start others takes 0.1 ms, and on busy cores up to 8.
FEW = 4096


def nearest(
    tree: cKDTree, places: FloatArray, k: int = 1, *, within: float = np.inf, threads: int | None = None
) -> tuple[FloatArray, IntArray]:
    """Return the distances from places (M, d) to the k nearest points of a tree, and which these are, (M,) or (M, k).

    What is farther than `within` is not searched for: its distance is infinite, and it has the number of no point.

    >>> distance, index = nearest(cKDTree([[0.0, 0.0], [2.0, 0.0]]), np.array([[1.5, 0.0], [9.0, 0.0]]), within=5.0)
    >>> distance.tolist(), index.tolist()
    ([0.5, inf], [1, 2])
    """
    if len(places) <= FEW:
        threads = 1
    workers = available() if threads is None else threads
    distance, index = tree.query(places, k=k, distance_upper_bound=within, workers=workers)
    return np.asarray(distance), np.asarray(index, dtype=np.intp)
