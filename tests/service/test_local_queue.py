"""The embedded queue with a real store, real blobs and real workers, whose tasks do as they are told."""

import asyncio
import os
import signal
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, text

from service.jobs.fit import Fit, FitStatus, PointSetRef
from service.queue.local import LocalQueue
from service.store.blobs import Blobs
from service.store.fits import SqlFits, sqlite_engine
from service.workers.pool import WorkerPool
from service.workers.progress import report


def task(blobs: Blobs, key: str, dimension: int, options: dict[str, Any]) -> bytes:
    """Do what the options say."""
    report({"degree": dimension})
    time.sleep(options.get("seconds", 0.0))
    if "once" in options and not Path(options["once"]).exists():
        Path(options["once"]).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if options.get("die"):
        os.kill(os.getpid(), signal.SIGKILL)
    if options.get("fail"):
        raise ValueError("as told")
    return blobs.get(key)


def loaded() -> None:
    """Load this module in the worker, so that the first fit need not wait for it."""


class Bench:
    """A queue and what it works with."""

    def __init__(self, folder: Path, engine: Engine, workers: WorkerPool) -> None:
        self.engine, self.store, self.blobs = engine, SqlFits(engine), Blobs(str(folder / "blobs"))
        self.workers = workers
        self.queue = self.anew()

    def anew(self) -> LocalQueue:
        return LocalQueue(self.store, self.blobs, self.workers, task, slots=1, deadline=1.0)

    def add(self, name: str, **options: Any) -> None:  # noqa: ANN401 - of any kind
        key = self.blobs.put(b"answer")
        self.store.add(Fit(name, FitStatus.ACCEPTED, PointSetRef(key, 3, 9), options, datetime.now(UTC)))

    def submit(self, name: str, **options: Any) -> None:  # noqa: ANN401 - of any kind
        self.add(name, **options)
        self.queue.submit(name)

    async def ended(self, name: str) -> Fit:
        await self.queue.wait(name, 20.0)
        return self.now(name)

    def now(self, name: str) -> Fit:
        fit = self.store.get(name)
        assert fit is not None
        return fit

    async def until(self, name: str, status: FitStatus) -> None:
        async with asyncio.timeout(10.0):
            while self.now(name).status is not status:  # noqa: ASYNC110 - the store tells nobody
                await asyncio.sleep(0.01)


@asynccontextmanager
async def bench(folder: Path) -> AsyncIterator[Bench]:
    engine, workers = sqlite_engine(folder / "fits.sqlite"), WorkerPool(1, 100)
    made = Bench(folder, engine, workers)
    await workers.run(loaded)
    try:
        yield made
    finally:
        await made.queue.close()
        await asyncio.to_thread(workers.close)
        engine.dispose()


def run(folder: Path, script: Callable[[Bench], Coroutine[Any, Any, None]]) -> None:
    async def whole() -> None:
        async with bench(folder) as made:
            await script(made)

    asyncio.run(whole())


def test_fits_are_run_and_end_as_they_should(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("good")
        b.submit("bad", fail=True)
        b.submit("deadly", die=True)
        b.submit("unlucky", once=str(tmp_path / "once"))
        b.submit("slow", seconds=30.0)
        b.submit("last")
        good, bad, deadly, unlucky, slow, last = [
            await b.ended(name) for name in ("good", "bad", "deadly", "unlucky", "slow", "last")
        ]
        assert (good.status, good.result, good.attempt) == (FitStatus.SUCCESSFUL, b"answer", 1)
        assert bad.failure is not None
        assert (bad.failure.kind, bad.failure.detail) == ("fit-error", "ValueError: as told")
        assert deadly.failure is not None
        assert (deadly.failure.kind, deadly.attempt) == ("worker-crashed", 2)
        assert (unlucky.status, unlucky.attempt) == (FitStatus.SUCCESSFUL, 2)
        assert slow.failure is not None
        assert (slow.failure.kind, slow.attempt) == ("deadline-exceeded", 1)
        assert last.status is FitStatus.SUCCESSFUL

    run(tmp_path, script)


def test_progress_is_there_while_a_fit_runs_and_not_after(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.5)
        await b.until("one", FitStatus.RUNNING)
        await asyncio.sleep(0.3)
        assert b.queue.progress("one") == [{"degree": 3}]
        await b.ended("one")
        assert b.queue.progress("one") == []

    run(tmp_path, script)


def test_a_dismissed_fit_stays_dismissed_and_the_next_one_runs(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        for name in ("running", "waiting", "next"):
            b.submit(name, seconds=0.0 if name == "next" else 30.0)
        await b.until("running", FitStatus.RUNNING)
        for name in ("running", "waiting"):
            assert b.store.dismiss(name)
            b.queue.cancel(name)
        assert (await b.ended("next")).status is FitStatus.SUCCESSFUL
        assert [b.now(name).status for name in ("running", "waiting")] == [FitStatus.DISMISSED] * 2

    run(tmp_path, script)


def test_a_closed_queue_leaves_its_fits_to_the_next(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("running", seconds=0.8)
        b.submit("waiting")
        await b.until("running", FitStatus.RUNNING)
        await b.queue.close()
        assert b.store.waiting() == ["running", "waiting"]
        b.queue = b.anew()
        await b.queue.resume()
        assert [(await b.ended(name)).status for name in ("running", "waiting")] == [FitStatus.SUCCESSFUL] * 2

    run(tmp_path, script)


def test_those_who_wait_are_let_go_when_the_server_stops(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.8)
        waiting = asyncio.create_task(b.queue.wait("one", 20.0))
        await b.until("one", FitStatus.RUNNING)
        b.queue.stop()
        await asyncio.wait_for(waiting, 0.3)
        assert b.queue.stopping
        assert b.now("one").status is FitStatus.RUNNING

    run(tmp_path, script)


def test_nobody_waits_longer_than_asked(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.8)
        began = time.monotonic()
        await b.queue.wait("one", 0.1)
        await b.queue.wait("unknown", 20.0)
        assert time.monotonic() - began < 0.5

    run(tmp_path, script)


def test_an_answer_outlives_a_store_that_fails_for_a_while(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.4)
        await b.until("one", FitStatus.RUNNING)
        with b.engine.begin() as connection:
            connection.execute(text("ALTER TABLE fits RENAME TO elsewhere"))
        await asyncio.sleep(0.8)
        with b.engine.begin() as connection:
            connection.execute(text("ALTER TABLE elsewhere RENAME TO fits"))
        ended = await b.ended("one")
        assert (ended.status, ended.result, ended.attempt) == (FitStatus.SUCCESSFUL, b"answer", 1)

    run(tmp_path, script)
