"""What the processes of a cluster share: one PostgreSQL, and a store of point sets."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import psycopg
from psycopg.conninfo import make_conninfo
from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

from service.bootstrap import fitting
from service.queue import procrastinate_jobs
from service.queue.procrastinate_jobs import ProcrastinateJobs
from service.settings import Settings
from service.store.blobs import Blobs
from service.store.engines import TIMEOUTS, postgres_engine
from service.store.fits import SqlFits
from service.store.migrations import MigrationStep

logger = logging.getLogger(__name__)

# Seconds between two tries to reach the database when a process starts.
CONNECT_PAUSE = 1.0


def conninfo(settings: Settings) -> str:
    """Return the connection string of the database, with the same timeouts as the engine."""
    return make_conninfo(str(settings.database_url), **TIMEOUTS)


def stores(settings: Settings, engine: Engine) -> tuple[SqlFits, Blobs]:
    """Return the store of fits in the database, and that of point sets."""
    store = SqlFits(engine, fitting.admission(settings), ProcrastinateJobs())
    return store, Blobs(settings.blobs_url or str(settings.data_dir.absolute() / "blobs"))


@asynccontextmanager
async def connected(settings: Settings) -> AsyncIterator[Engine]:
    """Yield an engine on the database."""
    queue = MigrationStep("procrastinate", "procrastinate_jobs", procrastinate_jobs.make, procrastinate_jobs.steps())
    engine = postgres_engine(str(settings.database_url), queue)
    try:
        yield engine
    finally:
        engine.dispose()


async def is_usable(engine: Engine) -> bool:
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
