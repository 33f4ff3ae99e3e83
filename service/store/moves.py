"""The moves of a fit in the database: each names the statuses it may start from, in its WHERE."""

from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from typing import Any, Protocol

import orjson
from sqlalchemy import ColumnElement, Connection, func, select, update

from service.jobs.fit import MAX_ABANDONED, Failure, FitStatus, sources
from service.store import rows
from service.store.tables import Moment, fits

FREE: dict[str, Any] = {"holder": None, "lease": None}


class Line(Protocol):
    """A queue in the same database, which fits join and leave in the transaction that stores the change."""

    def join(self, connection: Connection, fit_id: str, cost: float) -> int:
        """Put a fit in line and return its job there."""

    def leave(self, connection: Connection, job: int) -> None:
        """Take a job out of the line, or have its worker killed."""

    def tell(self, connection: Connection, fit_id: str) -> None:
        """Tell everybody that a fit has ended."""

    def in_line(self, connection: Connection, jobs: Iterable[int]) -> set[int]:
        """Return those of the jobs that nobody has taken yet, and that are due."""


def clock(connection: Connection) -> datetime:
    """Return the time: the database's own if several machines use it, whose clocks may differ."""
    if connection.dialect.name == "sqlite":
        return datetime.now(UTC)
    now: datetime = connection.execute(select(func.clock_timestamp(type_=Moment))).scalar_one()
    return now


def take_back(connection: Connection, line: Line | None, *where: ColumnElement[bool]) -> int:
    """Move running fits of dead holders back to accepted, or to failed if they had too many; return how many."""
    running = (fits.c.status == FitStatus.RUNNING, *where)
    why = Failure("worker-crashed", f"The process that supervised the fit died {MAX_ABANDONED} times.")
    ill = [
        one.id
        for one in connection.execute(select(fits.c.id, fits.c.abandoned).where(*running).with_for_update())
        if one.abandoned + 1 >= MAX_ABANDONED
    ]
    for fit_id in ill:
        values = {"finished": clock(connection), "failure": orjson.dumps(why), **FREE}
        move(connection, line, fit_id, FitStatus.FAILED, values)
    back = {"started": None, "progress": None, "abandoned": fits.c.abandoned + 1, **FREE}
    moved = update(fits).where(*running).values(status=FitStatus.ACCEPTED, touched=clock(connection), **back)
    return len(ill) + connection.execute(moved).rowcount


def rejoin(connection: Connection, line: Line, seconds: float) -> int:
    """Put live fits in line again that nobody has held for so long and that have no job there; return how many."""
    now = clock(connection)
    live = fits.c.status.in_([FitStatus.ACCEPTED, FitStatus.RUNNING])
    idle = (fits.c.touched < now - timedelta(seconds=seconds)) & func.coalesce(fits.c.lease < now, True)
    query = select(fits.c.id, fits.c.cost, fits.c.job).where(live, idle).with_for_update(skip_locked=True)
    found = connection.execute(query).all()
    in_line = line.in_line(connection, [one.job for one in found])
    lost = [one for one in found if one.job not in in_line]
    for one in lost:
        job = line.join(connection, one.id, one.cost)
        connection.execute(update(fits).where(fits.c.id == one.id).values(job=job, touched=now))
    return len(lost)


def move(  # noqa: PLR0913, PLR0917 - where, which, whither, and what changes with it
    connection: Connection,
    line: Line | None,
    fit_id: str,
    target: FitStatus,
    values: dict[str, Any],
    attempt: int | None = None,
) -> bool:
    """Make a legal move, fenced by the attempt if one is given; return whether it was made."""
    where = [fits.c.id == fit_id, fits.c.status.in_(sources(target))]
    if attempt is not None:
        where.append(fits.c.attempt == attempt)
    moved = rows.written(connection, where, status=target, touched=clock(connection), **values)
    if moved and target.final and line is not None:
        line.tell(connection, fit_id)
    return moved
