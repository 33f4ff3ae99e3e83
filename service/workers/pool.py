"""A pool of worker processes that can be killed one by one."""

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any, TypeVar
from uuid import uuid4

from pebble import ProcessExpired, ProcessPool

from service.jobs.errors import DeadlineExceededError, OutOfMemoryError, WorkerCrashedError
from service.workers import fork_server, progress, worker_side
from service.workers.kill import kill
from service.workers.seat import in_loop, outcome, scheduled

logger = logging.getLogger(__name__)

START_TRIES = 3  # of a worker: the system may kill one when memory is short
# Seconds between two looks whether a killed process is dead; most are after a few milliseconds.
DEATH_CHECK_SECONDS = 0.005

T = TypeVar("T")


class WorkerPool:
    """Runs module-level functions in worker processes: deadline, cancel and crash end one worker and one task only.

    Every worker has a pebble pool of its own, its *seat*. Workers of one pebble pool share pipes and locks, and one
    that is killed while it holds them blocks the others; pebble also ends a pool when an idle worker dies. Here only
    the seat is lost, and it is replaced.
    """

    def __init__(self, size: int, tasks_per_worker: int, memory: int, tries: int = 1, niceness: int = 0) -> None:
        """Make the seats; their workers start with the first task.

        Parameters
        ----------
        size
            The number of workers.
        tasks_per_worker
            Tasks after which a worker process is replaced.
        memory
            Bytes that each process may take.
        tries
            How often a task is started if its worker dies.
        niceness
            By how much the priority of the processes is lower than that of this one.

        """
        self._tasks_per_worker, self._memory, self._tries, self._niceness = tasks_per_worker, memory, tries, niceness
        self._inbox = progress.Inbox()
        self._seats = [self._new_seat() for _ in range(size)]
        # First in, first out: a seat whose worker was just killed gets the longest time to start another.
        self._free: asyncio.Queue[ProcessPool] = asyncio.Queue()
        self._evictions: set[asyncio.Task[None]] = set()
        self._used: set[ProcessPool] = set()  # seats whose worker was started
        self.deaths = 0
        for seat in self._seats:
            self._free.put_nowait(seat)

    @property
    def size(self) -> int:
        """Return the number of workers."""
        return len(self._seats)

    @property
    def busy(self) -> int:
        """Return how many workers have a task, or are being replaced."""
        return self.size - self._free.qsize()

    async def warm_up(self) -> None:
        """Return when every worker has started and has loaded its modules.

        Raises
        ------
        WorkerCrashedError
            If the processes of a seat die while they start, again and again.

        """
        await asyncio.gather(*(self._started() for _ in self._seats))

    async def _started(self) -> None:
        """Return when one more worker has started; a process that dies while it starts is replaced."""
        for _ in range(START_TRIES - 1):
            with suppress(WorkerCrashedError):
                return await self._once(worker_side.idle, (), None, None)
        return await self._once(worker_side.idle, (), None, None)

    async def run(
        self,
        function: Callable[..., T],
        *arguments: object,
        deadline: float | None = None,
        progress: Callable[[Any], None] | None = None,
    ) -> T:
        """Run a function in a worker and return its result, or raise its error.

        Cancelling the call, or exceeding the deadline, kills the worker's process. The call returns when that is dead
        and its seat has been replaced.

        Parameters
        ----------
        function, arguments
            A module-level function and its arguments, all picklable.
        deadline
            Seconds from the moment when a worker is free.
        progress
            Called in the event loop with every value that the function reports.

        Raises
        ------
        DeadlineExceededError, WorkerCrashedError, OutOfMemoryError
            If it took longer than the deadline, the process died, or it needed more memory than it may take.

        """
        for _ in range(self._tries - 1):
            with suppress(WorkerCrashedError):
                return await self._once(function, arguments, deadline, progress)
        return await self._once(function, arguments, deadline, progress)

    def close(self) -> None:
        """Kill every worker and wait until they are dead."""
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
                self._inbox.listen(task, in_loop(asyncio.get_running_loop(), progress))
            async with limit:
                seat = await self._usable(seat)
                answer: T = await outcome(seat, scheduled(seat, task, function, arguments))
        except (ProcessExpired, BrokenProcessPool) as error:
            await self._evict(seat, task)
            code = f" with code {error.exitcode}" if isinstance(error, ProcessExpired) else ""
            raise WorkerCrashedError(f"the worker process ended{code}") from error
        except (asyncio.CancelledError, OutOfMemoryError):  # a process that is full may stay so, and fail the next task
            await self._evict(seat, task)
            raise
        except Exception as error:
            if limit.expired():
                await self._evict(seat, task)
                raise DeadlineExceededError(f"the work took longer than {deadline:g} s and was stopped") from error
            self._free_seat(seat, task)
            raise
        self._free_seat(seat, task)
        return answer

    def _new_seat(self) -> ProcessPool:
        return ProcessPool(
            max_workers=1,
            max_tasks=self._tasks_per_worker,
            initializer=worker_side.initialise,
            initargs=[self._inbox.address, self._memory, self._niceness],
            context=fork_server.context(),
        )

    def _free_seat(self, seat: ProcessPool, task: str) -> None:
        self._inbox.forget(task)
        self._free.put_nowait(seat)

    async def _evict(self, seat: ProcessPool, task: str) -> None:
        """Kill the process that works on a task; when it is dead, replace its seat."""

        async def evict() -> None:
            worker = self._inbox.worker(task)
            while worker is not None and kill(worker):  # noqa: ASYNC110 - the system notifies only its parent
                await asyncio.sleep(DEATH_CHECK_SECONDS)
            self._free_seat(self._replace(seat), task)

        eviction = asyncio.create_task(evict())
        self._evictions.add(eviction)
        eviction.add_done_callback(self._evictions.discard)
        await asyncio.shield(eviction)

    async def _usable(self, seat: ProcessPool) -> ProcessPool:
        """Return this seat, or a new one if its idle worker was killed.

        Reading `active` starts the worker of a new seat, which takes too long for the event loop.
        """
        active = seat.active if seat in self._used else await asyncio.to_thread(lambda: seat.active)
        self._used.add(seat)
        return seat if active else self._replace(seat)

    def _replace(self, seat: ProcessPool) -> ProcessPool:
        """Put a new seat in the place of a broken one, which is closed in the background."""
        logger.warning("a worker process died and is replaced")
        self.deaths += 1
        self._used.discard(seat)
        seat.stop()  # type: ignore[no-untyped-call] # as above
        asyncio.get_running_loop().run_in_executor(None, seat.join)
        new = self._new_seat()
        self._seats[self._seats.index(seat)] = new
        return new
