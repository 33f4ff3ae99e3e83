"""Work spread over threads, in an order that does not depend on them."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Item = TypeVar("Item")
Result = TypeVar("Result")
Kind = TypeVar("Kind", bound=np.generic)

CHUNK = 16384  # rows at once: enough for numpy to let other threads run, few enough for the L2 cache


def mapped(function: Callable[[Item], Result], items: Iterable[Item], threads: int | None = None) -> list[Result]:
    """Return function(item) of every item, in order; `threads` at once, by default all `available`.

    It pays where the function spends its time in numpy on arrays of thousands of numbers, which lets other threads run.

    >>> mapped(len, ["one", "three"], threads=2)
    [3, 5]
    """
    items = list(items)
    workers = min(available() if threads is None else threads, len(items))
    if workers <= 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(function, items))


def by_rows(function: Callable[[slice], NDArray[Kind]], rows: int, threads: int | None = None) -> NDArray[Kind]:
    """Return function(slice) of all slices of some rows, concatenated, at least one.

    >>> x = np.arange(40000.0)
    >>> bool((by_rows(lambda part: 2.0 * x[part], len(x)) == 2.0 * x).all())
    True
    """
    parts = [slice(start, start + CHUNK) for start in range(0, max(rows, 1), CHUNK)]
    return np.concatenate(mapped(function, parts, threads))


def available() -> int:
    """Return how many threads this process is to use: OMP_NUM_THREADS if set, as for BLAS, else its number of cores."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    if asked.isdecimal() and int(asked):
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
