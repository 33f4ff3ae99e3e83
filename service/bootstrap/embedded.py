"""An embedded server: it stores everything in its data folder and runs fits itself."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from service.api.dependencies import Context
from service.bootstrap import fitting, server
from service.queue.embedded import EmbeddedQueue
from service.settings import Settings
from service.store.blobs import Blobs
from service.store.callbacks import SqlCallbacks
from service.store.data_folder import opened
from service.store.engines import sqlite_engine
from service.store.fits import SqlFits
from service.telemetry.metrics import Metrics


@asynccontextmanager
async def context(settings: Settings) -> AsyncIterator[Context]:
    """Yield the context of a server that resumes the fits which an earlier one left, and close it again."""
    with opened(settings.data_dir) as folder:
        engine = sqlite_engine(folder.database)
        store, blobs = SqlFits(engine, fitting.admission(settings)), Blobs(settings.blobs_url or str(folder.blobs))
        sweeping = asyncio.create_task(fitting.retention(settings, store, blobs).keep_sweeping())
        metrics, pools = Metrics(), fitting.Pools()
        try:
            async with fitting.fitters(settings, pools) as fitters:
                runner = fitting.runner(settings, store, blobs, fitters, metrics, publish=False)
                queue = EmbeddedQueue(store, runner, seats=settings.workers, short_seats=settings.short_workers)
                async with (
                    server.callbacks(settings, SqlCallbacks(engine)) as callbacks,
                    server.use_cases(settings, store, blobs, queue, callbacks, folder.files, pools) as (
                        fits,
                        files,
                    ),
                    fitting.watch(metrics, pools, store.load, fits.check) as watch,
                ):
                    try:
                        await queue.resume()
                        yield server.context(settings, fits, files, folder.incoming, watch)
                    finally:
                        await queue.close()
        finally:
            sweeping.cancel()
            engine.dispose()
