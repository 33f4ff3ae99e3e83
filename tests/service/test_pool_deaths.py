"""How worker processes end: they die, are killed inside a task, or run out of memory."""

import asyncio
import os
import signal
import subprocess
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from service.jobs.errors import DeadlineExceededError, OutOfMemoryError, WorkerCrashedError
from service.workers import worker_side
from service.workers.kill import kill
from service.workers.pool import WorkerPool
from service.workers.progress import report
from tests.service.pools import pid, run, sleep
from tests.service.running import alive, until


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


def test_a_worker_that_is_killed_while_it_starts_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_side, "idle", partial(die_once, tmp_path / "mark"))

    async def script(workers: WorkerPool) -> None:
        await workers.warm_up()
        assert (tmp_path / "mark").exists()
        assert await workers.run(pid)

    run(script)


def test_workers_that_die_again_and_again_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_side, "idle", die)

    async def script(workers: WorkerPool) -> None:
        with pytest.raises(WorkerCrashedError):
            await workers.warm_up()

    run(script)
