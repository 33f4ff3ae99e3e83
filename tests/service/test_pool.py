"""Worker processes: the modules they load, the results they return, and the seats they take."""

import asyncio
import os
import sys
import threading
import time
from typing import Any

import pytest

from service.jobs.errors import InvalidInputError, WorkerCrashedError
from service.workers.fork_server import BLAS_THREADS
from service.workers.pool import WorkerPool
from service.workers.progress import report
from tests.service.pools import pid, run, sleep
from tests.service.running import alive


def loaded() -> tuple[bool, list[str | None], int]:
    """Return whether the mathematics was there before the task, the BLAS settings, and the number of threads."""
    return (
        "ipcore.zero_set" in sys.modules,
        [os.environ.get(name) for name in BLAS_THREADS],
        threading.active_count(),
    )


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


def test_an_error_that_cannot_be_unpickled_ends_one_task_only() -> None:
    async def script(workers: WorkerPool) -> None:
        with pytest.raises(WorkerCrashedError):
            await workers.run(confuse)
        assert await workers.run(pid) > 0

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
