"""The only place where parts are put together."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI

from service.api.app import create_app
from service.api.context import Context
from service.api.limits import Limits
from service.formats.drawing import DrawingRoom
from service.formats.intake import Intake
from service.jobs.desk import FitDesk
from service.queue.local import LocalQueue
from service.settings import Settings
from service.store.blobs import Blobs
from service.store.fits import SqlFits, sqlite_engine
from service.store.folder import DataFolder, opened
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


def stop(app: FastAPI) -> None:
    """Have a running application accept nothing more and answer those who wait for a fit."""
    context: Context = app.state.context
    context.desk.stop()


def limits(settings: Settings) -> Limits:
    """Return what one request may ask for."""
    return Limits(
        body_bytes=settings.max_body_bytes,
        max_degree={2: settings.max_degree_2d, 3: settings.max_degree_3d},
        resolution={2: settings.max_resolution_2d, 3: settings.max_resolution_3d},
        system_bytes=settings.max_system_bytes,
        wait=settings.max_wait,
    )


@asynccontextmanager
async def _desk(settings: Settings, folder: DataFolder) -> AsyncIterator[FitDesk]:
    """Yield a desk whose workers are warm and which has taken up what an earlier server left, and close it again."""
    engine = sqlite_engine(folder.database)
    store, blobs = SqlFits(engine), Blobs(str(folder.blobs))
    fitters = WorkerPool(settings.workers, settings.tasks_per_worker)
    clerks = WorkerPool(1, settings.tasks_per_worker)  # reads and draws, so that neither waits for a fit
    queue = LocalQueue(store, blobs, fitters, tasks.fit, slots=settings.workers, deadline=settings.fit_deadline)
    reader = Intake(clerks, settings.max_points, settings.mesh_deadline)
    try:
        await asyncio.gather(fitters.warm_up(), clerks.warm_up())
        await queue.resume()
        yield FitDesk(store, blobs, queue, reader, DrawingRoom(clerks, settings.mesh_deadline))
    finally:
        await queue.close()
        await asyncio.gather(*(asyncio.to_thread(pool.close) for pool in (fitters, clerks)))
        engine.dispose()
