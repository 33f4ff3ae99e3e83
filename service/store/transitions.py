"""The transitions of fits in the database. Each names the statuses it may start from, in its WHERE clause."""

from collections.abc import Iterable, Mapping
from datetime import UTC, datetime, timedelta
from functools import cache
from types import MappingProxyType
from typing import Any, Protocol

import orjson
from sqlalchemy import ColumnElement, Connection, Update, bindparam, func, select, update

from service.jobs.fit import MAX_ABANDONED, Failure, FitStatus, sources
from service.store import outbox, turns
from service.store.schema import Moment, fits

# The columns of a fit that no process holds.
NOT_HELD: dict[str, Any] = {"holder": None, "lease": None}
# Statements that every fit needs are built once: that takes as long as to execute them.
_WHOLE = select(fits.c.whole).where(fits.c.id == bindparam("fit")).scalar_subquery()
_LOCK_WHOLE = select(fits.c.id).where(fits.c.id == _WHOLE).with_for_update()
_FAMILY = select(fits.c.parts, fits.c.whole, fits.c.client, fits.c.cost, fits.c.attempt, fits.c.short_lane).where(
    fits.c.id == bindparam("fit")
)


class JobQueue(Protocol):
    """A job queue in the same database, changed in the transaction that changes the fit."""

    def enqueue(self, connection: Connection, fit_id: str, place: int, *, short: bool) -> int:
        """Add a job for a fit to the queue of short or of long fits, and return its number. Low places are first."""

    def move_to_short(self, connection: Connection, job: int) -> bool:
        """Move a job that no worker has taken yet to the queue of short fits; return whether it was moved."""

    def cancel(self, connection: Connection, job: int) -> None:
        """Cancel a job; if it runs, its worker is told to abort it."""

    def notify_ended(self, connection: Connection, fit_id: str) -> None:
        """Notify all API processes that a fit has ended."""

    def queued(self, connection: Connection, jobs: Iterable[int]) -> set[int]:
        """Return those of the jobs that no worker has taken yet, and that are due soon."""


def clock(connection: Connection) -> datetime:
    """Return the time: that of a database which several machines may use, whose clocks may differ, else our own."""
    if connection.dialect.name == "sqlite":
        return datetime.now(UTC)
    now: datetime = connection.execute(select(func.clock_timestamp(type_=Moment))).scalar_one()
    return now


def requeue_abandoned(connection: Connection, queue: JobQueue | None, *where: ColumnElement[bool]) -> int:
    """Set running fits, whose holders are dead, back to accepted, or to failed if it was the last try.

    Return how many there were.
    """
    running = (fits.c.status == FitStatus.RUNNING, fits.c.unsummed == 0, *where)  # not those whose parts run
    why = Failure("worker-crashed", f"The process that supervised the fit died {MAX_ABANDONED} times.")
    failed = [
        one.id
        for one in connection.execute(select(fits.c.id, fits.c.abandoned).where(*running).with_for_update())
        if one.abandoned + 1 >= MAX_ABANDONED
    ]
    for fit_id in failed:
        values = {"finished": clock(connection), "failure": orjson.dumps(why), **NOT_HELD}
        transition(connection, queue, fit_id, FitStatus.FAILED, values)
    back = {"started": None, "progress": None, "abandoned": fits.c.abandoned + 1, **NOT_HELD}
    moved = update(fits).where(*running).values(status=FitStatus.ACCEPTED, touched=clock(connection), **back)
    return len(failed) + connection.execute(moved).rowcount


def requeue_lost(connection: Connection, queue: JobQueue, seconds: float) -> int:
    """Give a new job to each live fit that has none and that no process has held for `seconds`; return how many."""
    now = clock(connection)
    live = fits.c.status.in_([FitStatus.ACCEPTED, FitStatus.RUNNING])
    idle = (fits.c.touched < now - timedelta(seconds=seconds)) & func.coalesce(fits.c.lease < now, True)
    mine = (live, idle, fits.c.unsummed == 0)
    query = select(fits).where(*mine).with_for_update(skip_locked=True)
    found = connection.execute(query).all()
    queued = queue.queued(connection, [one.job for one in found])
    lost = [one for one in found if one.job not in queued]
    for one in lost:
        enqueue(connection, queue, one.id, one.place, short=one.short_lane, touched=now)
    return len(lost)


def enqueue(connection: Connection, queue: JobQueue, fit_id: str, place: int, *, short: bool, **values: object) -> None:
    """Add a job for a fit to the queue, in the lane of short fits or of all, and store its number with the fit."""
    job = queue.enqueue(connection, fit_id, place, short=short)
    connection.execute(update(fits).where(fits.c.id == fit_id).values(job=job, **values))


def transition(  # noqa: PLR0913 - where, which, to what, and the other changes
    connection: Connection,
    queue: JobQueue | None,
    fit_id: str,
    target: FitStatus,
    values: Mapping[str, Any],
    *,
    more: Mapping[str, int] = MappingProxyType({}),
    attempt: int | None = None,
    summed: bool = False,
) -> bool:
    """Set a fit to `target` and change other columns, if the table of transitions allows it; return whether it does.

    With `attempt`, only if that is the latest attempt; with `summed`, only if it does not wait for its parts. Columns
    in `more` grow by their numbers.
    """
    statement = _changing(target, frozenset(values), frozenset(more), held=attempt is not None, summed=summed)
    given = {"fit": fit_id, "held": attempt, "now": clock(connection)}
    given |= {f"new_{name}": value for name, value in values.items()}
    given |= {f"more_{name}": number for name, number in more.items()}
    done = bool(connection.execute(statement, given).rowcount)
    if done and target.final:
        _after_end(connection, queue, fit_id, target, values)
    return done


@cache
def _changing(target: FitStatus, names: frozenset[str], more: frozenset[str], *, held: bool, summed: bool) -> Update:
    """Return the statement of a transition that sets the columns `names` and adds to the columns `more`."""
    where = [fits.c.id == bindparam("fit"), fits.c.status.in_(sources(target))]
    if held:
        where.append(fits.c.attempt == bindparam("held"))
    if summed:
        where.append(fits.c.unsummed == 0)
    values: dict[str, Any] = {"status": target, "touched": bindparam("now")}
    values |= {name: bindparam(f"new_{name}") for name in names}
    values |= {name: fits.c[name] + bindparam(f"more_{name}") for name in more}
    return update(fits).where(*where).values(values)


def lock_whole(connection: Connection, fit_id: str) -> None:
    """If a fit is a part of another one, lock that other one until the transaction ends.

    Every transaction that changes both locks the whole before the part, so that two of them never wait for each other.
    SQLite lets only one transaction write at a time.
    """
    if connection.dialect.name == "sqlite":
        return
    connection.execute(_LOCK_WHOLE, {"fit": fit_id})


def _after_end(
    connection: Connection, queue: JobQueue | None, fit_id: str, target: FitStatus, values: Mapping[str, Any]
) -> None:
    """Do what follows from the end of a fit or a part, in the same transaction."""
    fit = connection.execute(_FAMILY, {"fit": fit_id}).one()
    if fit.parts:
        _remove_parts(connection, queue, fit_id)
    if fit.whole is None:
        outbox.make_due(connection, fit_id, target, values["finished"])
        if queue is not None:
            queue.notify_ended(connection, fit_id)
            _make_room(connection, queue, fit, target)
    elif target is FitStatus.SUCCESSFUL:
        _count_part(connection, queue, fit.whole)
    else:
        why = {name: values.get(name) for name in ("failure", "finished")}
        transition(connection, queue, fit.whole, target, why)


def _make_room(connection: Connection, queue: JobQueue, fit: Any, target: FitStatus) -> None:  # noqa: ANN401 - a row
    """Let the next short fit of the client have the place that this one had; do not count a fit that never ran."""
    if fit.short_lane and (following := turns.next_in_short_lane(connection, fit.client)) is not None:
        moved = following.job is not None and queue.move_to_short(connection, following.job)
        connection.execute(update(fits).where(fits.c.id == following.id).values(short_lane=moved))
    if target is FitStatus.DISMISSED and not fit.attempt and not fit.parts:
        turns.give_back(connection, fit.client, fit.cost)


def _remove_parts(connection: Connection, queue: JobQueue | None, whole: str) -> None:
    """Remove the parts of a fit. Those that run are aborted, or notice that their lease is gone."""
    live = fits.c.status.in_([FitStatus.ACCEPTED, FitStatus.RUNNING])
    jobs = connection.execute(select(fits.c.job).where(fits.c.whole == whole, live)).scalars().all()
    for job in jobs:
        if queue is not None and job is not None:
            queue.cancel(connection, job)
    connection.execute(fits.delete().where(fits.c.whole == whole))


def _count_part(connection: Connection, queue: JobQueue | None, whole: str) -> None:
    """Count a part of a fit as summed; after the last one, queue the fit itself."""
    connection.execute(update(fits).where(fits.c.id == whole).values(unsummed=fits.c.unsummed - 1))
    row = connection.execute(select(fits).where(fits.c.id == whole)).one()
    if row.unsummed == 0:
        transition(connection, queue, whole, FitStatus.ACCEPTED, {})
        if queue is not None:
            enqueue(connection, queue, whole, row.place, short=False)
