"""The moves of a fit in the database: each names the statuses it may start from, in its WHERE."""

from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from typing import Any, Protocol

import orjson
from sqlalchemy import ColumnElement, Connection, func, select, update

from service.jobs.fit import MAX_ABANDONED, Failure, Fit, FitStatus, sources
from service.store import mapping
from service.store.schema import Moment, fits

FREE: dict[str, Any] = {"holder": None, "lease": None}


class JobQueue(Protocol):
    """A queue in the same database, which fits join and leave in the transaction that stores the change."""

    def join(self, connection: Connection, fit_id: str, *, short: bool) -> int:
        """Put a fit in line, or in that of the short, and return its job there."""

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


def take_back(connection: Connection, line: JobQueue | None, *where: ColumnElement[bool]) -> int:
    """Move running fits of dead holders back to accepted, or to failed if they had too many; return how many."""
    running = (fits.c.status == FitStatus.RUNNING, fits.c.unsummed == 0, *where)  # by itself, and not in parts
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


def rejoin(connection: Connection, line: JobQueue, seconds: float) -> int:
    """Put live fits in line again that nobody has held for so long and that have no job there; return how many."""
    now = clock(connection)
    live = fits.c.status.in_([FitStatus.ACCEPTED, FitStatus.RUNNING])
    idle = (fits.c.touched < now - timedelta(seconds=seconds)) & func.coalesce(fits.c.lease < now, True)
    mine = (live, idle, fits.c.unsummed == 0)
    query = select(fits).where(*mine).with_for_update(skip_locked=True)
    found = connection.execute(query).all()
    in_line = line.in_line(connection, [one.job for one in found])
    lost = [one for one in found if one.job not in in_line]
    for one in lost:
        join(connection, line, mapping.to_fit(one), touched=now)
    return len(lost)


def join(connection: Connection, line: JobQueue, fit: Fit, **values: object) -> None:
    """Put a fit in line, and write down its job there."""
    job = line.join(connection, fit.id, short=fit.short)
    connection.execute(update(fits).where(fits.c.id == fit.id).values(job=job, **values))


def move(  # noqa: PLR0913, PLR0917 - where, which, whither, and what changes with it
    connection: Connection,
    line: JobQueue | None,
    fit_id: str,
    target: FitStatus,
    values: dict[str, Any],
    attempt: int | None = None,
) -> bool:
    """Make a legal move, fenced by the attempt if one is given; return whether it was made."""
    where = [fits.c.id == fit_id, fits.c.status.in_(sources(target))]
    if attempt is not None:
        where.append(fits.c.attempt == attempt)
    moved = mapping.written(connection, where, status=target, touched=clock(connection), **values)
    if moved and target.final:
        _ended(connection, line, fit_id, target, values)
    return moved


def hold_whole(connection: Connection, fit_id: str) -> None:
    """Lock the fit that this is a part of, if it is one. Who changes both locks the whole first: no two can block."""
    whole = select(fits.c.whole).where(fits.c.id == fit_id).scalar_subquery()
    connection.execute(select(fits.c.id).where(fits.c.id == whole).with_for_update())


def _ended(
    connection: Connection, line: JobQueue | None, fit_id: str, target: FitStatus, values: dict[str, Any]
) -> None:
    """Do what the end of a fit, or of a part, brings with it, in the same transaction."""
    fit = connection.execute(select(fits.c.parts, fits.c.whole).where(fits.c.id == fit_id)).one()
    if fit.parts:
        _clear(connection, line, fit_id)
    if fit.whole is None:
        if line is not None:
            line.tell(connection, fit_id)
    elif target is FitStatus.SUCCESSFUL:
        _count(connection, line, fit.whole)
    else:
        why = {name: values.get(name) for name in ("failure", "finished")}
        move(connection, line, fit.whole, target, why)


def _clear(connection: Connection, line: JobQueue | None, whole: str) -> None:
    """Remove the parts of a fit; those that run are killed, or find that they hold nothing any more."""
    live = fits.c.status.in_([FitStatus.ACCEPTED, FitStatus.RUNNING])
    jobs = connection.execute(select(fits.c.job).where(fits.c.whole == whole, live)).scalars().all()
    for job in jobs:
        if line is not None and job is not None:
            line.leave(connection, job)
    connection.execute(fits.delete().where(fits.c.whole == whole))


def _count(connection: Connection, line: JobQueue | None, whole: str) -> None:
    """Count a part as summed; after the last, put the fit itself in line."""
    connection.execute(update(fits).where(fits.c.id == whole).values(unsummed=fits.c.unsummed - 1))
    fit = mapping.to_fit(connection.execute(select(fits).where(fits.c.id == whole)).one())
    if fit.unsummed == 0:
        move(connection, line, whole, FitStatus.ACCEPTED, {})
        if line is not None:
            join(connection, line, fit)
