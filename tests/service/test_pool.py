"""Worker processes: the modules they load, the results they return, and how they end."""

import asyncio
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.jobs.errors import DeadlineExceededError, InvalidInputError, OutOfMemoryError, WorkerCrashedError
from service.workers.kill import kill
from service.workers.pool import BLAS_THREADS, WorkerPool
from service.workers.progress import report
from tests.service.running import alive, until

Script = Callable[[WorkerPool], Coroutine[Any, Any, None]]


def pid() -> int:
    return os.getpid()


def loaded() -> tuple[bool, list[str | None], int]:
    """Return whether the mathematics was there before the task, the BLAS settings, and the number of threads."""
    return (
        "ipcore.zero_set" in sys.modules,
        [os.environ.get(name) for name in BLAS_THREADS],
        threading.active_count(),
    )


def sleep(seconds: float) -> int:
    time.sleep(seconds)
    return os.getpid()


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def die_once(mark: Path) -> int:
    if not mark.exists():
        mark.touch()
        die()
    return os.getpid()


def factorise(size: int) -> int:
    """Spend many seconds inside one LAPACK call, in which Python takes no signals, and say when it took one."""
    table = np.random.default_rng(0).standard_normal((size, size))
    signal.signal(signal.SIGUSR1, lambda *_: report({"signal": 1}))
    report({"pid": os.getpid()})
    np.linalg.svd(table)
    return size


def take(count: int) -> int:
    return len(bytes(count))


def count(to: int) -> int:
    for i in range(to):
        report({"i": i})
    time.sleep(0.2)
    return to


def fail(at: tuple[str | int, ...]) -> None:
    raise InvalidInputError("wrong", at)


def echo(content: bytes) -> bytes:
    return content


class Stubborn(Exception):  # noqa: N818 - it is not about the name
    """An error that cannot be unpickled."""

    def __init__(self, one: str, two: str) -> None:
        super().__init__(one + two)


def confuse() -> None:
    raise Stubborn("one", "two")


@asynccontextmanager
async def pool(size: int = 1, tasks: int = 100) -> AsyncIterator[WorkerPool]:
    made = WorkerPool(size, tasks, 2**30)
    try:
        yield made
    finally:
        await asyncio.to_thread(made.close)


def run(script: Script, size: int = 1, tasks: int = 100) -> None:
    async def whole() -> None:
        async with pool(size, tasks) as workers:
            await script(workers)

    asyncio.run(whole())


def test_a_worker_starts_with_everything_loaded_and_one_blas_thread() -> None:
    async def script(workers: WorkerPool) -> None:
        await workers.warm_up()
        preloaded, blas, threads = await workers.run(loaded)
        assert preloaded
        assert blas == ["1"] * 4
        assert threads == 2  # the task's, and the one that watches the server

    run(script)


def test_large_answers_come_back_whole() -> None:
    async def script(workers: WorkerPool) -> None:
        content = os.urandom(10_000_000)
        assert await workers.run(echo, content) == content

    run(script)


def test_errors_come_back_with_their_place() -> None:
    async def script(workers: WorkerPool) -> None:
        with pytest.raises(InvalidInputError, match="wrong") as caught:
            await workers.run(fail, ("points", 3))
        assert caught.value.at == ("points", 3)

    run(script)


def test_reports_arrive_in_order_and_only_those_of_the_task() -> None:
    async def script(workers: WorkerPool) -> None:
        seen: list[Any] = []
        await workers.run(count, 5)
        await workers.run(count, 20, progress=seen.append)
        assert seen == [{"i": i} for i in range(20)]

    run(script)


def test_a_dead_worker_is_replaced_and_no_other_task_notices() -> None:
    async def script(workers: WorkerPool) -> None:
        other = asyncio.create_task(workers.run(sleep, 1.0))
        await asyncio.sleep(0.1)
        for _ in range(3):
            with pytest.raises(WorkerCrashedError):
                await workers.run(die)
        assert await other > 0
        assert await workers.run(pid) > 0

    run(script, size=2)


def test_a_task_may_be_tried_again_when_its_worker_dies(tmp_path: Path) -> None:
    async def script() -> None:
        workers = WorkerPool(1, 100, 2**30, tries=2)
        assert await workers.run(die_once, tmp_path / "died") > 0
        with pytest.raises(WorkerCrashedError):
            await workers.run(die)
        await asyncio.to_thread(workers.close)

    asyncio.run(script())


def test_a_process_counts_as_killed_even_if_nobody_buries_it() -> None:
    child = subprocess.Popen(["/bin/sleep", "60"])
    until(lambda: not kill(child.pid))
    assert child.wait() == -signal.SIGKILL  # until now it was a zombie
    assert not kill(child.pid)


def test_an_idle_worker_may_die() -> None:
    async def script(workers: WorkerPool) -> None:
        first = await workers.run(pid)
        os.kill(first, signal.SIGKILL)
        until(lambda: not alive(first))
        await asyncio.sleep(0.5)
        assert await workers.run(pid) != first

    run(script)


def test_an_error_that_cannot_be_unpickled_ends_one_task_only() -> None:
    async def script(workers: WorkerPool) -> None:
        with pytest.raises(WorkerCrashedError):
            await workers.run(confuse)
        assert await workers.run(pid) > 0

    run(script)


def test_a_task_over_its_deadline_is_killed() -> None:
    async def script(workers: WorkerPool) -> None:
        first = await workers.run(pid)
        with pytest.raises(DeadlineExceededError, match=r"0\.2 s"):
            await workers.run(sleep, 60.0, deadline=0.2)
        assert not alive(first)
        assert await workers.run(pid) != first

    run(script)


def test_a_cancelled_task_is_killed() -> None:
    async def script(workers: WorkerPool) -> None:
        first = await workers.run(pid)
        task = asyncio.create_task(workers.run(sleep, 60.0))
        await asyncio.sleep(0.2)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert await workers.run(pid) != first
        assert not alive(first)

    run(script)


@pytest.mark.parametrize("how", ["cancelled", "over its deadline"])
def test_a_task_inside_lapack_is_dead_at_once_and_its_seat_free(how: str) -> None:
    async def script(workers: WorkerPool) -> None:
        seen: list[dict[str, int]] = []
        await workers.warm_up()
        deadline = 3.0 if how == "over its deadline" else None
        task = asyncio.create_task(workers.run(factorise, 3000, deadline=deadline, progress=seen.append))
        while not seen:  # noqa: ASYNC110 - a report comes when it comes
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.3)
        os.kill(seen[0]["pid"], signal.SIGUSR1)
        await asyncio.sleep(0.3)
        assert len(seen) == 1  # Python, which would answer the signal, has no say: this is inside LAPACK
        if how == "cancelled":
            task.cancel()
        began = time.monotonic()
        with pytest.raises((asyncio.CancelledError, DeadlineExceededError)):
            await task
        assert not alive(seen[0]["pid"])
        # It is milliseconds; the call itself would take many seconds, and asking the process to end takes three.
        assert time.monotonic() - began < 2.0 + (deadline or 0.0)
        assert await workers.run(pid) != seen[0]["pid"]

    run(script)


def test_a_task_that_needs_too_much_memory_says_so_and_its_worker_is_replaced() -> None:
    async def script(workers: WorkerPool) -> None:
        first = await workers.run(pid)
        with pytest.raises(OutOfMemoryError, match=str(2**30)):
            await workers.run(take, 2**31)
        assert await workers.run(take, 2**20) == 2**20
        assert await workers.run(pid) != first  # what it still holds of the task would fail the next

    run(script)


def test_waiting_for_a_seat_can_be_cancelled() -> None:
    async def script(workers: WorkerPool) -> None:
        busy = asyncio.create_task(workers.run(sleep, 0.5))
        await asyncio.sleep(0.1)
        waiting = asyncio.create_task(workers.run(sleep, 60.0))
        await asyncio.sleep(0.1)
        waiting.cancel()
        await busy
        assert await asyncio.wait_for(workers.run(pid), 5.0) > 0

    run(script)


def test_workers_are_replaced_after_so_many_tasks() -> None:
    async def script(workers: WorkerPool) -> None:
        pids = [await workers.run(pid) for _ in range(6)]
        assert [pids.count(one) for one in dict.fromkeys(pids)] == [2, 2, 2]

    run(script, tasks=2)


def test_a_closed_pool_leaves_no_process() -> None:
    pids: list[int] = []

    async def script(workers: WorkerPool) -> None:
        pids.extend(await asyncio.gather(workers.run(sleep, 0.2), workers.run(sleep, 0.2)))
        asyncio.create_task(workers.run(sleep, 60.0)).add_done_callback(lambda task: task.cancelled())
        await asyncio.sleep(0.1)

    began = time.monotonic()
    run(script, size=2)
    assert time.monotonic() - began < 10.0
    assert len(set(pids)) == 2
    assert not [one for one in pids if alive(one)]
