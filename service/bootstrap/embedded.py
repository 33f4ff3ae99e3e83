"""One server that keeps everything in its data folder and runs fits itself."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from service.api.context import Context
from service.bootstrap import parts
from service.queue.local import LocalQueue
from service.settings import Settings
from service.store.blobs import Blobs
from service.store.fits import SqlFits
from service.store.folder import opened
from service.store.tables import sqlite_engine


@asynccontextmanager
async def context(settings: Settings) -> AsyncIterator[Context]:
    """Yield the parts of a server that has taken up what an earlier one left, and close them again."""
    with opened(settings.data_dir) as folder:
        engine = sqlite_engine(folder.database)
        store, blobs = SqlFits(engine, settings.queue_limit), Blobs(settings.blobs_url or str(folder.blobs))
        sweeping = asyncio.create_task(parts.retention(settings, store, blobs).keep_sweeping())
        try:
            async with parts.fitters(settings) as fitters:
                runner = parts.runner(settings, store, blobs, fitters, publish=False)
                queue = LocalQueue(store, runner, seats=settings.workers, short_seats=settings.short_workers)
                async with parts.desk(settings, store, blobs, queue) as desk:
                    try:
                        await queue.resume()
                        yield Context(desk, parts.limits(settings), folder.incoming)
                    finally:
                        await queue.close()
        finally:
            sweeping.cancel()
            engine.dispose()
