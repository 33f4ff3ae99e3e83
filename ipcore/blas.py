"""How many threads BLAS takes, while a piece of work needs it to take few."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock

import scipy.linalg  # noqa: F401 - brings its own BLAS, beside numpy's: both must be there when they are looked for
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
