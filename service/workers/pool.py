"""A pool of processes that can be killed one by one."""

import asyncio
import multiprocessing
import os
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar
from uuid import uuid4

from pebble import ProcessExpired, ProcessPool

from service.jobs.errors import DeadlineExceededError, WorkerCrashedError
from service.workers import progress

# One BLAS thread per worker: the pool already fills the cores, and small products run slower on several threads.
# Read by the libraries when they are first loaded, so it must stand in the environment before numpy is.
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
# Loaded once in the fork server, so that a new worker is ready in milliseconds.
PRELOAD = ["service.workers.tasks"]

T = TypeVar("T")


class WorkerPool:
    """Runs module-level functions in worker processes: deadline, cancel and crash end one worker and one task only."""

    def __init__(self, size: int, tasks_per_worker: int) -> None:
        """Prepare `size` workers, each replaced after `tasks_per_worker` tasks. They start with the first task."""
        os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(PRELOAD)
        self.size = size
        self._inbox = progress.Inbox()
        self._pool = ProcessPool(
            max_workers=size,
            max_tasks=tasks_per_worker,
            initializer=progress.connect,
            initargs=[self._inbox.address],
            context=context,
        )

    async def run(
        self,
        function: Callable[..., T],
        *arguments: object,
        deadline: float | None = None,
        progress: Callable[[Any], None] | None = None,
    ) -> T:
        """Run a function in a worker and return what it returns, or raise what it raises.

        Cancelling the call, or passing the deadline, kills the worker's process; another takes its place.

        Parameters
        ----------
        function, arguments
            A module-level function and its arguments, all picklable.
        deadline
            Seconds from the moment the worker starts on it.
        progress
            Called in the event loop with every value that the function reports.

        Raises
        ------
        DeadlineExceededError, WorkerCrashedError
            If the time was up, or the process died.

        """
        task, loop = uuid4().hex, asyncio.get_running_loop()
        if progress is not None:
            self._inbox.listen(task, _in_loop(loop, progress))
        future = self._pool.schedule(_run, args=(task, function, arguments), timeout=deadline)
        try:
            answer: T = await asyncio.wrap_future(future)
        except TimeoutError as error:
            raise DeadlineExceededError(f"the work took longer than {deadline:g} s and was stopped") from error
        except ProcessExpired as error:
            raise WorkerCrashedError(f"the worker process ended with code {error.exitcode}") from error
        else:
            return answer
        finally:
            self._inbox.forget(task)

    def close(self) -> None:
        """Kill every worker and wait until they are gone."""
        self._pool.stop()  # type: ignore[no-untyped-call] # pebble annotates all but this
        self._pool.join()
        self._inbox.close()


def _run(task: str, function: Callable[..., T], arguments: tuple[object, ...]) -> T:
    progress.begin(task)
    return function(*arguments)


def _in_loop(loop: asyncio.AbstractEventLoop, listener: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a listener that another thread may call, and that passes each report on to the event loop."""

    def pass_on(payload: object) -> None:
        with suppress(RuntimeError):  # the loop is closed: nobody is left to tell
            loop.call_soon_threadsafe(listener, payload)

    return pass_on
