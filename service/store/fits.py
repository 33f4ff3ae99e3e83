"""Fits in a SQL database, through SQLAlchemy Core."""

import sqlite3
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import orjson
from sqlalchemy import (
    Column,
    Connection,
    DateTime,
    Engine,
    Integer,
    LargeBinary,
    MetaData,
    Row,
    String,
    Table,
    create_engine,
    event,
    select,
    update,
)

from service.jobs.fit import Failure, Fit, FitStatus, PointSetRef, sources

metadata = MetaData()
fits = Table(
    "fits",
    metadata,
    Column("id", String, primary_key=True),
    Column("status", String, nullable=False, index=True),
    Column("input", String, nullable=False, index=True),
    Column("dimension", Integer, nullable=False),
    Column("points", Integer, nullable=False),
    Column("options", LargeBinary, nullable=False),
    Column("created", DateTime, nullable=False, index=True),
    Column("started", DateTime),
    Column("finished", DateTime),
    Column("attempt", Integer, nullable=False, default=0),
    Column("result", LargeBinary),
    Column("failure", LargeBinary),
)


def sqlite_engine(path: Path) -> Engine:
    """Return an engine on a SQLite file in WAL mode that flushes every commit to disk, and make its tables."""
    engine = create_engine(f"sqlite:///{path}")

    @event.listens_for(engine, "connect")
    def _durable(connection: sqlite3.Connection, _record: object) -> None:
        cursor = connection.cursor()
        for pragma in ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=10000"):
            cursor.execute(f"PRAGMA {pragma}")
        cursor.close()

    metadata.create_all(engine)
    return engine


class SqlFits:
    """The fit store. Every method is one transaction; a move names the statuses it may start from, in its WHERE."""

    def __init__(self, engine: Engine) -> None:
        """Use an engine whose tables exist."""
        self._engine = engine

    def add(self, fit: Fit) -> None:
        """Store a new fit."""
        row = {
            "id": fit.id,
            "status": fit.status,
            "input": fit.input.key,
            "dimension": fit.input.dimension,
            "points": fit.input.points,
            "options": orjson.dumps(fit.options),
            "created": _naive(fit.created),
            "attempt": fit.attempt,
        }
        with self._engine.begin() as connection:
            connection.execute(fits.insert().values(row))

    def get(self, fit_id: str) -> Fit | None:
        """Return the fit, or None."""
        with self._engine.connect() as connection:
            row = connection.execute(select(fits).where(fits.c.id == fit_id)).one_or_none()
        return None if row is None else _fit(row)

    def start(self, fit_id: str) -> int | None:
        """Move to running and return the attempt, from 1; None if the fit is not waiting."""
        values = {"started": _now(), "attempt": fits.c.attempt + 1}
        with self._engine.begin() as connection:
            if not _move(connection, fit_id, FitStatus.RUNNING, values):
                return None
            return int(connection.execute(select(fits.c.attempt).where(fits.c.id == fit_id)).scalar_one())

    def release(self, fit_id: str, attempt: int) -> bool:
        """Move from running back to accepted, if this attempt still holds the fit."""
        with self._engine.begin() as connection:
            return _move(connection, fit_id, FitStatus.ACCEPTED, {"started": None}, attempt)

    def finish(
        self, fit_id: str, attempt: int, status: FitStatus, result: bytes | None, failure: Failure | None
    ) -> bool:
        """Move to a final status with its result or failure, if this attempt still holds the fit."""
        reason = None if failure is None else orjson.dumps(failure)
        values = {"finished": _now(), "result": result, "failure": reason}
        with self._engine.begin() as connection:
            return _move(connection, fit_id, status, values, attempt)

    def dismiss(self, fit_id: str) -> bool:
        """Move to dismissed, if the fit is live."""
        with self._engine.begin() as connection:
            return _move(connection, fit_id, FitStatus.DISMISSED, {"finished": _now()})

    def remove(self, fit_id: str) -> bool:
        """Forget a fit that has ended."""
        ended = [status for status in FitStatus if status.final]
        with self._engine.begin() as connection:
            done = connection.execute(fits.delete().where(fits.c.id == fit_id, fits.c.status.in_(ended)))
        return bool(done.rowcount)

    def uses(self, key: str) -> bool:
        """Return whether any fit's input is this blob."""
        with self._engine.connect() as connection:
            return connection.execute(select(fits.c.id).where(fits.c.input == key).limit(1)).first() is not None

    def waiting(self) -> list[str]:
        """Return the ids of accepted fits, oldest first."""
        query = select(fits.c.id).where(fits.c.status == FitStatus.ACCEPTED).order_by(fits.c.created, fits.c.id)
        with self._engine.connect() as connection:
            return list(connection.execute(query).scalars())

    def recover(self) -> int:
        """Move every running fit back to accepted; the server that ran them is gone."""
        running = fits.c.status == FitStatus.RUNNING
        with self._engine.begin() as connection:
            return connection.execute(update(fits).where(running).values(status=FitStatus.ACCEPTED)).rowcount


def _move(
    connection: Connection, fit_id: str, target: FitStatus, values: dict[str, Any], attempt: int | None = None
) -> bool:
    """Make a legal move, fenced by the attempt if one is given; return whether it was made."""
    where = [fits.c.id == fit_id, fits.c.status.in_(sources(target))]
    if attempt is not None:
        where.append(fits.c.attempt == attempt)
    done = connection.execute(update(fits).where(*where).values(status=target, **values))
    return bool(done.rowcount)


def _fit(row: Row[Any]) -> Fit:
    return Fit(
        id=row.id,
        status=FitStatus(row.status),
        input=PointSetRef(row.input, row.dimension, row.points),
        options=orjson.loads(row.options),
        created=row.created.replace(tzinfo=UTC),
        started=row.started and row.started.replace(tzinfo=UTC),
        finished=row.finished and row.finished.replace(tzinfo=UTC),
        attempt=row.attempt,
        result=row.result,
        failure=None if row.failure is None else Failure(**orjson.loads(row.failure)),
    )


def _now() -> datetime:
    return _naive(datetime.now(UTC))


def _naive(moment: datetime) -> datetime:
    """Return a moment as SQLite keeps it: UTC without a zone."""
    return moment.astimezone(UTC).replace(tzinfo=None)
