"""A process that runs the fits of a cluster."""

import asyncio
import logging
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from service.api.watch import Watch
from service.bootstrap import cluster, fitting
from service.jobs.errors import ShuttingDownError
from service.jobs.retention import Retention
from service.jobs.store_calls import call_store
from service.queue.procrastinate_worker import ProcrastinateWorker
from service.queue.runner import Runner
from service.settings import Settings
from service.store.fits import SqlFits
from service.telemetry.metrics import Metrics

logger = logging.getLogger(__name__)


async def work(settings: Settings) -> None:
    """Run fits until SIGTERM; on a second SIGTERM, end at once."""
    metrics, pools = Metrics(), fitting.Pools()
    async with cluster.connected(settings) as engine, fitting.fitters(settings, pools) as fitters:
        store, blobs = cluster.stores(settings, engine)
        runner = fitting.runner(settings, store, blobs, fitters, metrics, publish=True)
        worker = _worker(settings, store, runner, fitting.retention(settings, store, blobs))
        for one in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(one, worker.stop)

        async def check() -> None:
            if worker.stopping:
                raise ShuttingDownError("the worker is stopping")
            await call_store(store.count_waiting)

        async with fitting.watch(metrics, pools, store.load, check) as watch, _answering(settings, watch):
            while not (worker.stopping or await cluster.is_usable(engine)):  # noqa: ASYNC110 - nothing tells when it is
                await asyncio.sleep(cluster.CONNECT_PAUSE)
            if not worker.stopping:
                await worker.work(settings.shutdown_grace)


@asynccontextmanager
async def _answering(settings: Settings, watch: Watch) -> AsyncIterator[None]:
    """Answer supervisors if there is a port for them; only then are the libraries of a web server loaded."""
    if settings.probe_port is None:
        yield
        return
    from service.bootstrap.probes import serving  # noqa: PLC0415 - see above

    async with serving(settings, settings.probe_port, watch):
        yield


def _worker(settings: Settings, store: SqlFits, runner: Runner, retention: Retention) -> ProcrastinateWorker:
    """Return the worker; one process of all cleans up the store, too."""

    def clean_up() -> bool:
        if found := store.requeue_lost(2.0 * settings.lease):
            logger.warning("%d fits had no job any more and were queued again", found)
        return retention.sweep()[1]

    return ProcrastinateWorker(
        store,
        runner,
        clean_up,
        url=cluster.conninfo(settings),
        seats=settings.workers,
        short_seats=settings.short_workers,
        lease=settings.lease,
    )
