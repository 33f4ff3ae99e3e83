"""Work divided among threads, with results that do not depend on their number, while BLAS keeps to its limits.

`using` sets the number of threads for everything within it, `available` says what it is. `ordered`, `mapped` and
`by_rows` divide work and yield its results in the order of the items, so that sums of them are always the same.
`limited` limits the threads of BLAS alone.
"""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sized
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from threading import Lock
from typing import TypeVar

import numpy as np
import scipy.linalg  # noqa: F401 - loads its own BLAS beside numpy's: both must be there when their settings are sought
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController, threadpool_limits

Item = TypeVar("Item")
Result = TypeVar("Result")
Kind = TypeVar("Kind", bound=np.generic)

SLICE_ROWS = 16384  # enough for numpy to let other threads run, few enough for the L2 cache
AHEAD = 2  # items per thread that are begun before their results are needed: no thread waits, and memory stays bounded

_requested: ContextVar[int | None] = ContextVar("threads", default=None)


@contextmanager
def using(threads: int | None) -> Iterator[None]:
    """Let everything within use at most so many threads, those of BLAS included; None changes nothing.

    >>> with using(1):
    ...     available()
    1
    """
    if threads is None:
        yield
        return
    token = _requested.set(threads)
    try:
        with limited(threads):
            yield
    finally:
        _requested.reset(token)


def available() -> int:
    """Return how many threads this call is to use.

    It is the number given to `using`; else OMP_NUM_THREADS if set, as for BLAS; else the process's number of cores.
    """
    return _requested.get() or _of_the_process(os.environ.get("OMP_NUM_THREADS", ""))


@lru_cache(maxsize=8)
def _of_the_process(setting: str) -> int:
    """Return the number that OMP_NUM_THREADS has been set to; the number of cores if it is no positive number."""
    if setting.isdecimal() and int(setting):
        return int(setting)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def ordered(function: Callable[[Item], Result], items: Iterable[Item], threads: int | None = None) -> Iterator[Result]:
    """Yield function(item) for every item, in order, computed in `threads` threads; by default in all `available`.

    Items are taken from the iterable as they are needed, so a stream of them is never held as a whole. Threads are
    faster where the function spends its time in numpy on arrays of thousands of numbers, where other threads can run.
    BLAS uses one thread in each. Within a thread, `ordered` starts no further threads.

    >>> list(ordered(len, iter(["one", "three"]), threads=2))
    [3, 5]
    """
    workers = available() if threads is None or _requested.get() == 1 else threads
    if isinstance(items, Sized):
        workers = min(workers, len(items))
    if workers <= 1:
        yield from map(function, items)
        return
    pool, waiting = _pool(workers), deque[Future[Result]]()
    with limited(1):
        try:
            for item in items:
                waiting.append(pool.submit(function, item))
                if len(waiting) >= AHEAD * workers:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:  # after an error, nothing more is begun
                future.cancel()


@lru_cache(maxsize=8)
def _pool(workers: int) -> ThreadPoolExecutor:
    """Return a pool of so many threads, in which `available` is 1.

    It is kept: to start threads takes as long as a small piece of work.
    """
    return ThreadPoolExecutor(workers, "ipcore", initializer=_requested.set, initargs=(1,))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # a forked process does not inherit the threads


def mapped(function: Callable[[Item], Result], items: Iterable[Item], threads: int | None = None) -> list[Result]:
    """Return function(item) for every item, in order, as `ordered` yields them.

    >>> mapped(len, ["one", "three"], threads=2)
    [3, 5]
    """
    return list(ordered(function, list(items), threads))


def by_rows(function: Callable[[slice], NDArray[Kind]], rows: int, threads: int | None = None) -> NDArray[Kind]:
    """Return the concatenation of function(slice) over slices that cover `rows` rows; of one empty slice if 0.

    >>> x = np.arange(40000.0)
    >>> bool((by_rows(lambda part: 2.0 * x[part], len(x)) == 2.0 * x).all())
    True
    """
    return np.concatenate(mapped(function, slices(rows), threads))


def slices(rows: int) -> list[slice]:
    """Return slices of `SLICE_ROWS` rows that cover `rows` rows, at least one slice.

    >>> slices(20000)
    [slice(0, 16384, None), slice(16384, 20000, None)]
    """
    return [slice(start, min(start + SLICE_ROWS, rows)) for start in range(0, max(rows, 1), SLICE_ROWS)]


class _BlasLimits:
    """The limits in force at this moment, set by any thread: BLAS has one setting for the whole process."""

    def __init__(self) -> None:
        self._controller = ThreadpoolController()
        self._lock = Lock()
        self._limits: list[int] = []
        self._original: threadpool_limits | None = None

    def enter(self, threads: int) -> None:
        """Add a limit, and set BLAS to the lowest one."""
        with self._lock:
            self._limits.append(threads)
            limiter = self._controller.limit(limits=min(self._limits), user_api="blas")
            self._original = self._original or limiter  # the first one knows the setting from before any limit

    def leave(self, threads: int) -> None:
        """Take a limit away, and set BLAS to the lowest one that remains, or back to its original setting."""
        with self._lock:
            self._limits.remove(threads)
            if self._limits:
                self._controller.limit(limits=min(self._limits), user_api="blas")
            elif self._original is not None:
                self._original.restore_original_limits()
                self._original = None


@lru_cache(maxsize=1)
def _blas_limits() -> _BlasLimits:
    """Return the limits of this process; to look for the loaded BLAS libraries takes time."""
    return _BlasLimits()


@contextmanager
def limited(threads: int) -> Iterator[None]:
    """Limit the threads of BLAS for the whole process; of several limits at the same time the lowest is in force.

    When the last one is left, in whatever order, the setting is what it was before the first.

    >>> with limited(1):
    ...     pass
    """
    _blas_limits().enter(threads)
    try:
        yield
    finally:
        _blas_limits().leave(threads)
