"""A pool of processes that can be killed one by one."""

import asyncio
import logging
import multiprocessing
import os
import signal
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar
from uuid import uuid4

from pebble import ProcessExpired, ProcessFuture, ProcessPool

from service.jobs.errors import DeadlineExceededError, OutOfMemoryError, WorkerCrashedError
from service.workers import process, progress

logger = logging.getLogger(__name__)

# One BLAS thread per worker: the pool already fills the cores, and small products run slower on several threads.
# Read by the libraries when they are first loaded, so it must stand in the environment before numpy is.
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
# Loaded once in the fork server, so that a new worker is ready in milliseconds.
PRELOAD = ["service.workers.tasks", "service.formats.zero_set.exporter", "service.formats.points.reader"]
# How often a task that runs is checked to have a pool that is alive.
LOOK = 1.0
# Seconds between two looks whether a killed process is gone; most are in a few milliseconds.
DEATH = 0.005

T = TypeVar("T")


class WorkerPool:
    """Runs module-level functions in worker processes: deadline, cancel and crash end one worker and one task only.

    Every worker has a pebble pool to itself, its *seat*. Workers of one pebble pool share pipes and locks, and one that
    is killed while it holds them takes the others along; pebble also gives a pool up when an idle worker dies. Here a
    seat is all that is lost, and it is replaced.
    """

    def __init__(self, size: int, tasks_per_worker: int, memory: int, tries: int = 1) -> None:
        """Prepare workers, which start with the first task.

        Parameters
        ----------
        size
            How many.
        tasks_per_worker
            Tasks after which a worker is replaced.
        memory
            Bytes that each may take.
        tries
            How often a task may be started whose worker dies.

        """
        os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
        self._tasks_per_worker, self._memory, self._tries = tasks_per_worker, memory, tries
        self._inbox = progress.Inbox()
        self._seats = [self._new_seat() for _ in range(size)]
        # First in, first out: a seat whose worker was just killed has the longest time to get another.
        self._free: asyncio.Queue[ProcessPool] = asyncio.Queue()
        self._evictions: set[asyncio.Task[None]] = set()
        for seat in self._seats:
            self._free.put_nowait(seat)

    async def warm_up(self) -> None:
        """Return when every worker has started and has loaded what it needs."""
        await asyncio.gather(*(self.run(process.idle) for _ in self._seats))

    async def run(
        self,
        function: Callable[..., T],
        *arguments: object,
        deadline: float | None = None,
        progress: Callable[[Any], None] | None = None,
    ) -> T:
        """Run a function in a worker and return what it returns, or raise what it raises.

        Cancelling the call, or passing the deadline, kills the worker's process. Only when that is dead does another
        take its place, and does the call return.

        Parameters
        ----------
        function, arguments
            A module-level function and its arguments, all picklable.
        deadline
            Seconds from the moment there is a worker for it.
        progress
            Called in the event loop with every value that the function reports.

        Raises
        ------
        DeadlineExceededError, WorkerCrashedError, OutOfMemoryError
            If the time was up, the process died, or it needed more memory than it may take.

        """
        for _ in range(self._tries - 1):
            with suppress(WorkerCrashedError):
                return await self._once(function, arguments, deadline, progress)
        return await self._once(function, arguments, deadline, progress)

    def close(self) -> None:
        """Kill every worker and wait until they are gone."""
        for seat in self._seats:
            seat.stop()  # type: ignore[no-untyped-call] # pebble annotates all but this
        with ThreadPoolExecutor(len(self._seats)) as threads:
            list(threads.map(ProcessPool.join, self._seats))
        self._inbox.close()

    async def _once(
        self,
        function: Callable[..., T],
        arguments: tuple[object, ...],
        deadline: float | None,
        progress: Callable[[Any], None] | None,
    ) -> T:
        task = uuid4().hex
        seat: ProcessPool = await self._free.get()
        limit = asyncio.timeout(deadline)
        try:
            if progress is not None:
                self._inbox.listen(task, _in_loop(asyncio.get_running_loop(), progress))
            async with limit:
                seat = await self._usable(seat)
                answer: T = await _outcome(seat, _scheduled(seat, task, function, arguments))
        except (ProcessExpired, BrokenProcessPool) as error:
            await self._evict(seat, task)
            code = f" with code {error.exitcode}" if isinstance(error, ProcessExpired) else ""
            raise WorkerCrashedError(f"the worker process ended{code}") from error
        except (asyncio.CancelledError, OutOfMemoryError):  # one that is full may stay so, and fail what comes next
            await self._evict(seat, task)
            raise
        except Exception as error:
            if limit.expired():
                await self._evict(seat, task)
                raise DeadlineExceededError(f"the work took longer than {deadline:g} s and was stopped") from error
            self._leave(seat, task)
            raise
        self._leave(seat, task)
        return answer

    def _new_seat(self) -> ProcessPool:
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(PRELOAD)
        return ProcessPool(
            max_workers=1,
            max_tasks=self._tasks_per_worker,
            initializer=process.enter,
            initargs=[self._inbox.address, self._memory],
            context=context,
        )

    def _leave(self, seat: ProcessPool, task: str) -> None:
        self._inbox.forget(task)
        self._free.put_nowait(seat)

    async def _evict(self, seat: ProcessPool, task: str) -> None:
        """Kill whatever process still works on the task, and put a new seat in the place of its own when it is dead."""

        async def evict() -> None:
            worker = self._inbox.worker(task)
            while worker is not None and killed(worker):  # noqa: ASYNC110 - the system tells only its parent
                await asyncio.sleep(DEATH)
            self._leave(self._replace(seat), task)

        eviction = asyncio.create_task(evict())
        self._evictions.add(eviction)
        eviction.add_done_callback(self._evictions.discard)
        await asyncio.shield(eviction)

    async def _usable(self, seat: ProcessPool) -> ProcessPool:
        """Return this seat, or a new one if it broke while nobody looked: its idle worker was killed.

        To ask starts the worker of a seat that has none yet: long enough to be done off the event loop.
        """
        active = await asyncio.to_thread(lambda: seat.active)
        return seat if active else self._replace(seat)

    def _replace(self, seat: ProcessPool) -> ProcessPool:
        """Put a new seat in the place of a broken one, which is cleared away in the background."""
        logger.warning("a worker process died and is replaced")
        seat.stop()  # type: ignore[no-untyped-call] # as above
        asyncio.get_running_loop().run_in_executor(None, seat.join)
        new = self._new_seat()
        self._seats[self._seats.index(seat)] = new
        return new


def killed(worker: int) -> bool:
    """Kill a process at once, in the middle of a LAPACK call or wherever it is; return whether it is still there."""
    try:
        os.kill(worker, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return not _is_zombie(worker)


def _is_zombie(worker: int) -> bool:
    """Return whether a process is dead and only its number is left.

    It may stay so for good: when its fork server was killed, too, and the process with the number 1, which inherits it,
    takes no care, as in a container without an init.
    """
    with suppress(OSError):  # there is no /proc on macOS, whose first process takes care
        return Path(f"/proc/{worker}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z"
    return False


def _scheduled(
    seat: ProcessPool, task: str, function: Callable[..., T], arguments: tuple[object, ...]
) -> ProcessFuture[T]:
    try:
        return seat.schedule(process.run, args=(task, function, arguments))
    except RuntimeError as error:  # it broke after it was looked at
        raise BrokenProcessPool(str(error)) from error


async def _outcome(seat: ProcessPool, future: ProcessFuture[T]) -> T:
    """Return what the task returns, watching that its pool is there to finish it; cancelled, cancel the task."""
    answer = asyncio.wrap_future(future)
    try:
        while not (await asyncio.wait((answer,), timeout=LOOK))[0]:
            if not seat.active and not answer.done():
                raise BrokenProcessPool("the pool ended before its task")
        return answer.result()
    finally:
        answer.cancel()


def _in_loop(loop: asyncio.AbstractEventLoop, listener: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a listener that another thread may call, and that passes each report on to the event loop."""

    def pass_on(payload: object) -> None:
        with suppress(RuntimeError):  # the loop is closed: nobody is left to tell
            loop.call_soon_threadsafe(listener, payload)

    return pass_on
