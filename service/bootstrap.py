"""The only place where parts are put together."""

import asyncio
import os
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from uuid import uuid4

from fastapi import FastAPI

from service.api.app import create_app
from service.api.context import Context
from service.api.limits import Limits
from service.formats.drawing import DrawingRoom
from service.formats.intake import Intake
from service.jobs.desk import FitDesk
from service.jobs.fit import Holder
from service.jobs.retention import Retention
from service.queue.local import LocalQueue
from service.queue.runner import Runner
from service.settings import Settings
from service.store.blobs import Blobs
from service.store.fits import SqlFits
from service.store.folder import DataFolder, opened
from service.store.tables import sqlite_engine
from service.workers import tasks
from service.workers.pool import WorkerPool


def embedded(settings: Settings) -> FastAPI:
    """Return the application of one server that keeps everything in its data folder."""

    @asynccontextmanager
    async def startup() -> AsyncIterator[Context]:
        with opened(settings.data_dir) as folder:
            async with _desk(settings, folder) as desk:
                yield Context(desk, limits(settings), folder.incoming)

    return create_app(startup)


async def drain(app: FastAPI, seconds: float) -> None:
    """Have a running application accept nothing more, and let what runs end in so much time."""
    context: Context = app.state.context
    await context.desk.drain(seconds)


def hurry(app: FastAPI) -> None:
    """End a drain at once; may be called from a signal handler."""
    context: Context = app.state.context
    asyncio.get_running_loop().call_soon_threadsafe(context.desk.hurry)


def limits(settings: Settings) -> Limits:
    """Return what one request may ask for."""
    return Limits(
        body_bytes=settings.max_body_bytes,
        max_degree={2: settings.max_degree_2d, 3: settings.max_degree_3d},
        resolution={2: settings.max_resolution_2d, 3: settings.max_resolution_3d},
        system_bytes=settings.max_system_bytes,
        wait=settings.max_wait,
    )


def holder(settings: Settings) -> Holder:
    """Return what this process is called among those that run fits."""
    return Holder(f"{socket.gethostname()}-{os.getpid()}-{uuid4().hex[:8]}", settings.lease)


@asynccontextmanager
async def _desk(settings: Settings, folder: DataFolder) -> AsyncIterator[FitDesk]:
    """Yield a desk whose workers are warm and which has taken up what an earlier server left, and close it again."""
    engine = sqlite_engine(folder.database)
    store, blobs = SqlFits(engine, settings.queue_limit), Blobs(str(folder.blobs))
    seats, short = settings.workers, settings.short_workers
    fitters = WorkerPool(seats + short, settings.tasks_per_worker, settings.worker_memory)
    clerks = WorkerPool(1, settings.tasks_per_worker, settings.worker_memory)  # read and draw; neither waits for a fit
    runner = Runner(store, blobs, fitters, tasks.fit, holder=holder(settings), deadline=settings.fit_deadline)
    queue = LocalQueue(store, runner, seats=seats, short_seats=short)
    reader = Intake(clerks, settings.max_points, settings.mesh_deadline)
    retention = Retention(store, blobs, settings.keep_seconds, settings.keep_bytes)
    sweeping = asyncio.create_task(retention.keep_sweeping())
    try:
        await asyncio.gather(fitters.warm_up(), clerks.warm_up())
        await queue.resume()
        yield FitDesk(store, blobs, queue, reader, DrawingRoom(clerks, settings.mesh_deadline))
    finally:
        sweeping.cancel()
        await queue.close()
        await asyncio.gather(*(asyncio.to_thread(pool.close) for pool in (fitters, clerks)))
        engine.dispose()
