"""The processes of a cluster: stateless replicas of the API, and workers, around one PostgreSQL."""

import asyncio
import logging
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import psycopg
from psycopg.conninfo import make_conninfo
from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

from service.api.dependencies import Context
from service.bootstrap import components
from service.bootstrap.probes import serving
from service.jobs.errors import ShuttingDownError
from service.jobs.retention import Retention
from service.jobs.store_calls import call_store
from service.queue import procrastinate_jobs
from service.queue.listener import FitListener
from service.queue.procrastinate_jobs import ProcrastinateJobs
from service.queue.procrastinate_worker import ProcrastinateWorker
from service.queue.runner import Runner
from service.settings import Settings
from service.store.blobs import Blobs
from service.store.callbacks import SqlCallbacks
from service.store.engines import TIMEOUTS, postgres_engine
from service.store.fits import SqlFits
from service.store.migrations import MigrationStep
from service.telemetry.metrics import Metrics
from service.temporary_folders import temporary_folder

logger = logging.getLogger(__name__)

# Seconds between two tries to reach the database when a process starts.
CONNECT_PAUSE = 1.0


@asynccontextmanager
async def context(settings: Settings) -> AsyncIterator[Context]:
    """Yield the context of a replica of the API, and close it again."""
    async with _engine(settings) as engine:
        await _is_usable(engine)  # if not, every request tries again, and is answered with 503 until it is
        store, blobs = _stores(settings, engine)
        queue = FitListener(store, _conninfo(settings))
        listening = asyncio.create_task(queue.listen())
        metrics, pools = Metrics(), components.Pools()
        try:
            with temporary_folder() as incoming, temporary_folder() as folder:
                async with (
                    components.callbacks(settings, SqlCallbacks(engine)) as callbacks,
                    components.use_cases(settings, store, blobs, queue, callbacks, folder, pools) as (
                        fits,
                        files,
                    ),
                    components.watch(metrics, pools, store.load, fits.check) as watch,
                ):
                    yield components.context(settings, fits, files, incoming, watch)
        finally:
            listening.cancel()


async def work(settings: Settings) -> None:
    """Run fits until SIGTERM; on a second SIGTERM, end at once."""
    metrics, pools = Metrics(), components.Pools()
    async with _engine(settings) as engine, components.fitters(settings, pools) as fitters:
        store, blobs = _stores(settings, engine)
        runner = components.runner(settings, store, blobs, fitters, metrics, publish=True)
        worker = _worker(settings, store, runner, components.retention(settings, store, blobs))
        for one in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(one, worker.stop)

        async def check() -> None:
            if worker.stopping:
                raise ShuttingDownError("the worker is stopping")
            await call_store(store.count_waiting)

        async with components.watch(metrics, pools, store.load, check) as watch, serving(settings, watch):
            while not (worker.stopping or await _is_usable(engine)):  # noqa: ASYNC110 - nothing notifies when it is
                await asyncio.sleep(CONNECT_PAUSE)
            if not worker.stopping:
                await worker.work(settings.shutdown_grace)


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
        url=_conninfo(settings),
        seats=settings.workers,
        short_seats=settings.short_workers,
        lease=settings.lease,
    )


def _conninfo(settings: Settings) -> str:
    """Return the connection string of the database, with the same timeouts as the engine."""
    return make_conninfo(str(settings.database_url), **TIMEOUTS)


def _stores(settings: Settings, engine: Engine) -> tuple[SqlFits, Blobs]:
    store = SqlFits(engine, components.admission(settings), ProcrastinateJobs())
    return store, Blobs(settings.blobs_url or str(settings.data_dir.absolute() / "blobs"))


@asynccontextmanager
async def _engine(settings: Settings) -> AsyncIterator[Engine]:
    """Yield an engine on the database."""
    queue = MigrationStep("procrastinate", "procrastinate_jobs", procrastinate_jobs.make, procrastinate_jobs.steps())
    engine = postgres_engine(str(settings.database_url), queue)
    try:
        yield engine
    finally:
        engine.dispose()


async def _is_usable(engine: Engine) -> bool:
    """Return whether the database can be connected to; its tables are then up to date.

    Raises
    ------
    DatabaseVersionError
        If it is not for this version of the program.

    """
    try:
        await asyncio.to_thread(lambda: engine.connect().close())
    except (SQLAlchemyError, psycopg.Error) as error:
        logger.warning("the database cannot be used; the next try is in %g s: %s", CONNECT_PAUSE, error)
        return False
    return True
