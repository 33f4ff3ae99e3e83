"""The nearest points of a tree, searched for on as many threads as are worth starting."""

import numpy as np
from scipy.spatial import cKDTree

from ipcore._threads import available
from ipcore._typing import FloatArray, IntArray

# Up to so many places are searched for in one thread. That takes some 2 ms; to start other threads takes 0.1 ms, and on
# busy cores up to 8 ms.
SERIAL_QUERIES = 4096


def nearest(
    tree: cKDTree, places: FloatArray, k: int = 1, *, within: float = np.inf, threads: int | None = None
) -> tuple[FloatArray, IntArray]:
    """Return the distances from places (M, d) to the k nearest points of a tree, and the numbers of these points.

    Both are (M,) if k is 1, else (M, k). Points farther than `within` are not searched for: their distance is infinite,
    and their number is N, which no point has.

    >>> distance, index = nearest(cKDTree([[0.0, 0.0], [2.0, 0.0]]), np.array([[1.5, 0.0], [9.0, 0.0]]), within=5.0)
    >>> distance.tolist(), index.tolist()
    ([0.5, inf], [1, 2])
    """
    if len(places) <= SERIAL_QUERIES:
        threads = 1
    workers = available() if threads is None else threads
    distance, index = tree.query(places, k=k, distance_upper_bound=within, workers=workers)
    return np.asarray(distance), np.asarray(index, dtype=np.intp)
