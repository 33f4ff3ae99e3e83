"""An embedded queue for tests: a real store, real blobs and real workers, whose tasks do what their input says."""

import asyncio
import os
import signal
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import orjson
from sqlalchemy import Engine, text

import ipcore
from service.jobs.admission import Admission
from service.jobs.errors import NotReadyError
from service.jobs.fit import SHORT_SECONDS, Fit, FitStatus, PointSetRef
from service.jobs.lease_holder import LeaseHolder
from service.jobs.parts import split
from service.jobs.requested_options import RequestedOptions
from service.jobs.slices import Frame, Slice
from service.queue.embedded import EmbeddedQueue
from service.queue.runner import Runner
from service.queue.work import Lanes, Tasks
from service.store.blobs import Blobs
from service.store.engines import sqlite_engine
from service.store.fits import SqlFits
from service.workers.pool import WorkerPool
from service.workers.progress import report

LONG = 10.0 * SHORT_SECONDS


def fit(blobs: Blobs, given: PointSetRef, _options: ipcore.FitOptions) -> bytes:
    """Do what the stored input says, which is a JSON object and not a point set."""
    return act(instructions(blobs, given))


def part(blobs: Blobs, given: PointSetRef, _options: ipcore.FitOptions, some: Slice) -> bytes:
    """Do what the input says of all parts, or of the one that begins at a row."""
    orders = instructions(blobs, given)
    act(orders.get("parts", {}) | orders.get(str(some.first), {}))
    return f"{some.first}-{some.last}".encode()


def rest(blobs: Blobs, given: PointSetRef, _options: ipcore.FitOptions, sums: list[bytes]) -> bytes:
    """Do what the input says, and return what the parts did."""
    act(instructions(blobs, given))
    return b" ".join(sums)


def instructions(blobs: Blobs, given: PointSetRef) -> dict[str, Any]:
    orders: dict[str, Any] = orjson.loads(blobs.get(given.key))
    return orders


def act(orders: dict[str, Any]) -> bytes:
    report({"degree": 3})
    time.sleep(orders.get("seconds", 0.0))
    if orders.get("greedy"):
        bytes(2**31)
    if "once" in orders and not Path(orders["once"]).exists():
        Path(orders["once"]).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if "away" in orders and (orders["away"] == "/" or not Path(orders["away"]).exists()):
        raise NotReadyError("the point set cannot be read")
    if orders.get("die"):
        os.kill(os.getpid(), signal.SIGKILL)
    if orders.get("fail"):
        raise ValueError("as told")
    return b"answer"


def loaded() -> None:
    """Load this module in the worker, so that the first fit need not wait for it."""


class Bench:
    """A queue with its store, its blobs and its workers."""

    def __init__(self, folder: Path, engine: Engine, workers: WorkerPool) -> None:
        self.engine, self.store, self.blobs = engine, SqlFits(engine, Admission(1000)), Blobs(str(folder / "blobs"))
        self.workers = workers
        self.queue = self.anew()

    def anew(self) -> EmbeddedQueue:
        tasks = Tasks(fit, part, rest)
        runner = Runner(
            self.store,
            self.blobs,
            Lanes(self.workers, self.workers),
            tasks,
            holder=LeaseHolder("me", 1.0),
            deadline=5.0,
        )
        return EmbeddedQueue(self.store, runner, seats=1, short_seats=1)

    def new_fit(self, name: str, orders: dict[str, Any], client: str = "", cost: float = LONG) -> Fit:
        """Return a fit of nine points whose stored input says what its task does."""
        given = PointSetRef(self.blobs.put(orjson.dumps(orders)), 3, 9)
        return Fit(name, FitStatus.ACCEPTED, given, RequestedOptions({}), datetime.now(UTC), client, cost)

    def submit(self, name: str, client: str = "", cost: float = LONG, **orders: Any) -> None:  # noqa: ANN401 - any
        self.queue.submit(self.store.add(self.new_fit(name, orders, client, cost), list)[0])

    def submit_split(self, name: str, orders: dict[str, Any], cost: float = LONG) -> None:
        """Submit a fit of three parts."""
        whole, parts = split(self.new_fit(name, orders, cost=cost), Frame((0.0, 0.0, 0.0), 1.0), 3)
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
