"""The processes of a cluster: stateless replicas of the API, and workers, around one PostgreSQL."""

import asyncio
import logging
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from psycopg.conninfo import make_conninfo
from sqlalchemy import Engine
from sqlalchemy.exc import OperationalError

from service.api.context import Context
from service.bootstrap import parts
from service.queue.crew import Crew
from service.queue.postgres import PostgresLine, schema
from service.queue.replica import ReplicaQueue
from service.settings import Settings
from service.store.blobs import Blobs
from service.store.fits import SqlFits
from service.store.tables import PATIENCE, postgres_engine

logger = logging.getLogger(__name__)

# Seconds between tries, while there is no database yet when a process starts.
PAUSE = 1.0


@asynccontextmanager
async def context(settings: Settings) -> AsyncIterator[Context]:
    """Yield the parts of a replica of the API, and close them again."""
    async with _engine(str(settings.database_url)) as engine:
        store, blobs = _stores(settings, engine)
        queue = ReplicaQueue(store, _patient(settings))
        listening = asyncio.create_task(queue.listen())
        try:
            with TemporaryDirectory(prefix="ipfit-") as incoming:
                async with parts.desk(settings, store, blobs, queue) as desk:
                    yield Context(desk, parts.limits(settings), Path(incoming))
        finally:
            listening.cancel()


async def work(settings: Settings) -> None:
    """Run fits until SIGTERM; on a second one, end at once."""
    async with _engine(str(settings.database_url)) as engine, parts.fitters(settings) as fitters:
        store, blobs = _stores(settings, engine)
        retention = parts.retention(settings, store, blobs)

        def tidy() -> None:
            if found := store.rejoin(2.0 * settings.lease):
                logger.warning("%d fits had no job any more and were queued again", found)
            retention.sweep()

        crew = Crew(
            store,
            parts.runner(settings, store, blobs, fitters, publish=True),
            tidy,
            url=_patient(settings),
            seats=settings.workers,
            short_seats=settings.short_workers,
            lease=settings.lease,
        )
        for one in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(one, crew.stop)
        await crew.work(settings.shutdown_grace)


def _patient(settings: Settings) -> str:
    """Return how to reach the database, with the same patience everywhere."""
    return make_conninfo(str(settings.database_url), **PATIENCE)


def _stores(settings: Settings, engine: Engine) -> tuple[SqlFits, Blobs]:
    store = SqlFits(engine, settings.queue_limit, PostgresLine())
    return store, Blobs(settings.blobs_url or str(settings.data_dir.absolute() / "blobs"))


@asynccontextmanager
async def _engine(url: str) -> AsyncIterator[Engine]:
    """Yield an engine on a database that is ready, as soon as it is."""
    while True:
        try:
            engine = await asyncio.to_thread(postgres_engine, url, schema())
            break
        except OperationalError as error:
            logger.warning("the database cannot be reached; the next try is in %g s: %s", PAUSE, error)
            await asyncio.sleep(PAUSE)
    try:
        yield engine
    finally:
        engine.dispose()
