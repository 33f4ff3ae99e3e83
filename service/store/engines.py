"""Connections to the two kinds of database, whose tables are made or migrated before they are used."""

import sqlite3
from pathlib import Path
from threading import Event, Lock

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy import exc as errors
from sqlalchemy.pool import ConnectionPoolEntry, NullPool

from service.store.migrations import MigrationStep, prepare
from service.store.schema import FITS

# A PostgreSQL that does not answer must not delay a request for minutes: seconds to connect, milliseconds until
# unanswered packets end a connection, and milliseconds for a statement.
TIMEOUTS = {
    "connect_timeout": 5,
    "tcp_user_timeout": 10_000,
    "keepalives_idle": 5,
    "keepalives_interval": 2,
}
# Seconds that a transaction waits for others to write to SQLite.
LOCK_SECONDS = 10
OPTIONS = "-c statement_timeout=30000 -c idle_in_transaction_session_timeout=30000 -c synchronous_commit=on"


def sqlite_engine(path: Path) -> Engine:
    """Return an engine on a SQLite file in WAL mode that flushes every commit to disk, and create its tables."""
    engine = create_engine(f"sqlite:///{path}")

    @event.listens_for(engine, "connect")
    def _durable(connection: sqlite3.Connection, _record: object) -> None:
        cursor = connection.cursor()
        for pragma in ("journal_mode=WAL", "synchronous=FULL", f"busy_timeout={1000 * LOCK_SECONDS}"):
            cursor.execute(f"PRAGMA {pragma}")
        cursor.close()

    prepare(engine, [FITS])
    _write_in_turn(engine)
    return engine


def _write_in_turn(engine: Engine) -> None:
    """Let transactions of this process that write wait for each other here.

    SQLite itself lets one write at a time, and has the others look again after pauses of up to a tenth of a second.
    """
    writer = Lock()

    @event.listens_for(engine, "before_cursor_execute")
    def _begin_to_write(
        connection: Connection, _cursor: object, statement: str, _given: object, _context: object, _many: object
    ) -> None:
        if not connection.info.get("writes") and statement.startswith(("INSERT", "UPDATE", "DELETE")):
            if not writer.acquire(timeout=LOCK_SECONDS):
                raise errors.TimeoutError("the database is busy: others have been writing for too long")
            connection.info["writes"] = True

    @event.listens_for(engine, "checkin")
    def _end(_connection: object, record: ConnectionPoolEntry) -> None:
        if record.info.pop("writes", False):
            writer.release()


def postgres_engine(url: str, *queue: MigrationStep) -> Engine:
    """Return an engine on a PostgreSQL database, which need not answer yet.

    Before the first connection is used, the tables of fits and of the queue are created or migrated.

    Parameters
    ----------
    url
        `postgresql://…`.
    queue
        The tables of a queue in the same database.

    """
    where = "postgresql+psycopg://" + url.partition("://")[2]
    arguments = {**TIMEOUTS, "options": OPTIONS}
    first = create_engine(where, connect_args=arguments, poolclass=NullPool)
    engine = create_engine(
        where, connect_args=arguments, pool_pre_ping=True, pool_timeout=10, pool_size=10, max_overflow=10
    )
    lock, prepared = Lock(), Event()

    @event.listens_for(engine, "connect")
    def _prepare(_connection: object, _record: object) -> None:
        with lock:
            if not prepared.is_set():
                prepare(first, [FITS, *queue])
                prepared.set()

    return engine
