"""An embedded queue as a test has it: a real store, real blobs and real workers, whose tasks do as they are told."""

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

from service.jobs.cost import SHORT
from service.jobs.errors import NotReadyError
from service.jobs.fit import Fit, FitStatus, Holder, PointSetRef
from service.jobs.parts import split
from service.jobs.slices import Frame, Slice
from service.queue.embedded import EmbeddedQueue
from service.queue.runner import Runner, Tasks
from service.store.blobs import Blobs
from service.store.fits import SqlFits
from service.store.schema import sqlite_engine
from service.workers.pool import WorkerPool
from service.workers.progress import report

LONG = 10.0 * SHORT


def task(blobs: Blobs, key: str, dimension: int, options: dict[str, Any]) -> bytes:
    """Do what the options say."""
    report({"degree": dimension})
    time.sleep(options.get("seconds", 0.0))
    if options.get("greedy"):
        bytes(2**31)
    if "once" in options and not Path(options["once"]).exists():
        Path(options["once"]).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if "away" in options and (options["away"] == "/" or not Path(options["away"]).exists()):
        raise NotReadyError("the point set cannot be read")
    if options.get("die"):
        os.kill(os.getpid(), signal.SIGKILL)
    if options.get("fail"):
        raise ValueError("as told")
    return blobs.get(key)


def part(blobs: Blobs, key: str, dimension: int, options: dict[str, Any], some: Slice) -> bytes:
    """Do what the options say of parts, or of the one that begins at a row."""
    task(blobs, key, dimension, options.get("parts", {}) | options.get(str(some.first), {}))
    return f"{some.first}-{some.last}".encode()


def rest(blobs: Blobs, key: str, dimension: int, options: dict[str, Any], sums: list[bytes]) -> bytes:
    """Do what the options say, and return what the parts did."""
    task(blobs, key, dimension, options)
    return b" ".join(sums)


def loaded() -> None:
    """Load this module in the worker, so that the first fit need not wait for it."""


class Bench:
    """A queue and what it works with."""

    def __init__(self, folder: Path, engine: Engine, workers: WorkerPool) -> None:
        self.engine, self.store, self.blobs = engine, SqlFits(engine, 1000), Blobs(str(folder / "blobs"))
        self.workers = workers
        self.queue = self.anew()

    def anew(self) -> EmbeddedQueue:
        tasks = Tasks(task, part, rest)
        runner = Runner(self.store, self.blobs, self.workers, tasks, holder=Holder("me", 1.0), deadline=1.0)
        return EmbeddedQueue(self.store, runner, seats=1, short_seats=1)

    def submit(self, name: str, client: str = "", cost: float = LONG, **options: Any) -> None:  # noqa: ANN401 - any
        key = self.blobs.put(b"answer")
        fit = Fit(name, FitStatus.ACCEPTED, PointSetRef(key, 3, 9), options, datetime.now(UTC), client, cost)
        self.queue.submit(self.store.add(fit, list))

    def submit_split(self, name: str, options: dict[str, Any], cost: float = LONG) -> None:
        """Submit a fit of three parts."""
        key = self.blobs.put(b"answer")
        fit = Fit(name, FitStatus.ACCEPTED, PointSetRef(key, 3, 9), options, datetime.now(UTC), cost=cost)
        whole, parts = split(fit, Frame((0.0, 0.0, 0.0), 1.0), 3)
        self.store.add(whole, list, parts)
        for one in parts:
            self.queue.submit(one)

    async def ended(self, name: str) -> Fit:
        await self.queue.wait(name, 20.0)
        return self.now(name)

    def now(self, name: str) -> Fit:
        fit = self.store.get(name)
        assert fit is not None
        return fit

    def rows(self) -> int:
        """Return how many fits and parts are stored."""
        with self.engine.connect() as connection:
            return int(connection.execute(text("SELECT count(*) FROM fits")).scalar_one())

    async def until(self, name: str, status: FitStatus) -> None:
        async with asyncio.timeout(10.0):
            while self.now(name).status is not status:  # noqa: ASYNC110 - the store tells nobody
                await asyncio.sleep(0.01)


@asynccontextmanager
async def bench(folder: Path) -> AsyncIterator[Bench]:
    engine, workers = sqlite_engine(folder / "fits.sqlite"), WorkerPool(2, 100, 2**30)
    made = Bench(folder, engine, workers)
    await asyncio.gather(workers.run(loaded), workers.run(loaded))
    await made.queue.resume()
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
