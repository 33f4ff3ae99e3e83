"""Work spread over threads, in an order that does not depend on them."""

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
import scipy.linalg  # noqa: F401 - brings its own BLAS, beside numpy's: both must be there when they are looked for
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController, threadpool_limits


class _Limits:
    """The limits asked for at this moment, from any thread: BLAS has one setting for the whole process."""

    def __init__(self) -> None:
        self._controller = ThreadpoolController()
        self._lock = Lock()
        self._asked: list[int] = []
        self._first: threadpool_limits | None = None

    def enter(self, threads: int) -> None:
        with self._lock:
            self._asked.append(threads)
            limiter = self._controller.limit(limits=min(self._asked), user_api="blas")
            self._first = self._first or limiter  # it knows what the setting was when nobody asked for anything

    def leave(self, threads: int) -> None:
        with self._lock:
            self._asked.remove(threads)
            if self._asked:
                self._controller.limit(limits=min(self._asked), user_api="blas")
            elif self._first is not None:
                self._first.restore_original_limits()
                self._first = None


@lru_cache(maxsize=1)
def _limits() -> _Limits:
    return _Limits()


@contextmanager
def limited(threads: int) -> Iterator[None]:
    """Let BLAS take so many threads at most, for the whole process: the least of what is asked for at the same time.

    The setting is what it was when the last one has left, in whatever order they leave.

    >>> with limited(1):
    ...     pass
    """
    _limits().enter(threads)
    try:
        yield
    finally:
        _limits().leave(threads)


Item = TypeVar("Item")
Result = TypeVar("Result")
Kind = TypeVar("Kind", bound=np.generic)

CHUNK = 16384  # rows at once: enough for numpy to let other threads run, few enough for the L2 cache
AHEAD = 2  # items per thread that are taken before their turn: no thread waits for the next, and memory stays bounded

_asked: ContextVar[int | None] = ContextVar("threads", default=None)


@contextmanager
def using(threads: int | None) -> Iterator[None]:
    """Let everything within use at most so many threads, BLAS included; None changes nothing.

    >>> with using(1):
    ...     available()
    1
    """
    if threads is None:
        yield
        return
    token = _asked.set(threads)
    try:
        with limited(threads):
            yield
    finally:
        _asked.reset(token)


def available() -> int:
    """Return how many threads this call is to use.

    What `using` says; else OMP_NUM_THREADS if set, as for BLAS; else the process's number of cores.
    """
    return _asked.get() or _of_the_process(os.environ.get("OMP_NUM_THREADS", ""))


@lru_cache(maxsize=8)
def _of_the_process(asked: str) -> int:
    if asked.isdecimal() and int(asked):
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def ordered(function: Callable[[Item], Result], items: Iterable[Item], threads: int | None = None) -> Iterator[Result]:
    """Yield function(item) of every item, in order; `threads` at once, by default all `available`.

    Items are taken as they are needed, so a stream of them is never held as a whole. It pays where the function spends
    its time in numpy on arrays of thousands of numbers, which lets other threads run; BLAS keeps to one thread in each.

    >>> list(ordered(len, iter(["one", "three"]), threads=2))
    [3, 5]
    """
    workers = available() if threads is None or _asked.get() == 1 else threads
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
    """Return threads that stay: to start some takes as long as a small piece of work. What they do uses one each."""
    return ThreadPoolExecutor(workers, "ipcore", initializer=_asked.set, initargs=(1,))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # threads do not follow into a forked process


def mapped(function: Callable[[Item], Result], items: Iterable[Item], threads: int | None = None) -> list[Result]:
    """Return function(item) of every item, in order, as `ordered` yields them.

    >>> mapped(len, ["one", "three"], threads=2)
    [3, 5]
    """
    return list(ordered(function, list(items), threads))


def by_rows(function: Callable[[slice], NDArray[Kind]], rows: int, threads: int | None = None) -> NDArray[Kind]:
    """Return function(slice) of all slices of some rows, concatenated, at least one.

    >>> x = np.arange(40000.0)
    >>> bool((by_rows(lambda part: 2.0 * x[part], len(x)) == 2.0 * x).all())
    True
    """
    return np.concatenate(mapped(function, slices(rows), threads))


def slices(rows: int) -> list[slice]:
    """Return slices of `CHUNK` rows that cover so many, at least one.

    >>> slices(20000)
    [slice(0, 16384, None), slice(16384, 20000, None)]
    """
    return [slice(start, min(start + CHUNK, rows)) for start in range(0, max(rows, 1), CHUNK)]
