"""A stateless replica of the API in a cluster."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from service.api.dependencies import Context
from service.bootstrap import cluster, fitting, server
from service.queue.listener import FitListener
from service.settings import Settings
from service.store.callbacks import SqlCallbacks
from service.telemetry.metrics import Metrics
from service.temporary_folders import temporary_folder


@asynccontextmanager
async def context(settings: Settings) -> AsyncIterator[Context]:
    """Yield the context of a replica of the API, and close it again."""
    async with cluster.connected(settings) as engine:
        await cluster.is_usable(engine)  # if not, every request tries again, and is answered with 503 until it is
        store, blobs = cluster.stores(settings, engine)
        queue = FitListener(store, cluster.conninfo(settings))
        listening = asyncio.create_task(queue.listen())
        metrics, pools = Metrics(), fitting.Pools()
        try:
            with temporary_folder() as incoming, temporary_folder() as folder:
                async with (
                    server.callbacks(settings, SqlCallbacks(engine)) as callbacks,
                    server.use_cases(settings, store, blobs, queue, callbacks, folder, pools) as (
                        fits,
                        files,
                    ),
                    fitting.watch(metrics, pools, store.load, fits.check) as watch,
                ):
                    yield server.context(settings, fits, files, incoming, watch)
        finally:
            listening.cancel()
