"""Questions about stored fits that change nothing."""

from collections.abc import Iterable
from dataclasses import replace
from datetime import timedelta
from typing import Any

import orjson
from sqlalchemy import ColumnElement, Connection, Row, and_, bindparam, case, func, null, select

from service.jobs.admission import Usage
from service.jobs.fit import SHORT_SECONDS, Fit, FitStatus
from service.jobs.lane_load import LaneLoad
from service.jobs.page import Page
from service.store import acceptances, mapping, outbox
from service.store.schema import callbacks, fits
from service.store.transitions import clock

_WHOLE = func.coalesce(fits.c.whole, fits.c.id)  # of a part its fit, of a fit itself
ENDED = [status for status in FitStatus if status.final]
MOST_OUTDATED = 1000  # fits that are named at once
# As in `transitions`, built once.
_FITS = select(fits, *outbox.CALLBACK_COLUMNS).outerjoin(callbacks, callbacks.c.fit == fits.c.id)
_BY_ID, _BY_KEY = _FITS.where(fits.c.id == bindparam("fit")), _FITS.where(fits.c.key == bindparam("stored_key"))
_SHORT = and_(fits.c.whole.is_(None), fits.c.cost <= SHORT_SECONDS).label("short")  # as `Fit.short`
_LOAD = (
    select(_SHORT, fits.c.status, func.count().label("number"), func.min(fits.c.created).label("oldest"))
    .where(fits.c.status.in_([FitStatus.ACCEPTED, FitStatus.RUNNING]), fits.c.unsummed == 0)
    .group_by(_SHORT, fits.c.status)
)
_MINE = fits.c.client == bindparam("client")
_USAGE = select(
    func.count(_WHOLE.distinct()),
    func.sum(fits.c.cost),
    func.sum(fits.c.size),
    func.count(case((_MINE, _WHOLE)).distinct()),
    func.sum(case((_MINE, fits.c.cost), else_=0.0)),
).where(*mapping.queued())


def fit(connection: Connection, fit_id: str) -> Fit | None:
    """Return a fit with its callback, or None."""
    return _with_callback(connection.execute(_BY_ID, {"fit": fit_id}).one_or_none())


def fit_of_key(connection: Connection, key: str) -> Fit | None:
    """Return the fit with this idempotency key, as it is stored, with its callback; or None."""
    return _with_callback(connection.execute(_BY_KEY, {"stored_key": key}).one_or_none())


def _with_callback(row: Row[Any] | None) -> Fit | None:
    return None if row is None else replace(mapping.to_fit(row), callback=outbox.of_row(row))


def count_waiting(connection: Connection) -> int:
    """Return how many fits wait for a worker, themselves or with a part."""
    return int(connection.execute(select(func.count(_WHOLE.distinct())).where(*mapping.queued())).scalar_one())


def usage(connection: Connection, client: str, owner: str) -> Usage:
    """Return what waits, and what a client has of it; of an owner's fits, how many were accepted in an hour."""
    waiting = connection.execute(_USAGE, {"client": client}).one()
    recent, age = acceptances.recent(connection, owner, clock(connection)) if owner else (0, 0.0)
    count_all, seconds, size, own, own_seconds = (value or 0 for value in waiting)
    return Usage(int(count_all), float(seconds), int(size), int(own), float(own_seconds), recent, age)


def load(connection: Connection) -> list[LaneLoad]:
    """Return how much there is to do in each lane."""
    now, found = clock(connection), {name: LaneLoad(name) for name in ("short", "long")}
    for row in connection.execute(_LOAD):
        lane = found["short" if row.short else "long"]
        if row.status is FitStatus.RUNNING:
            found[lane.lane] = replace(lane, running=row.number)
        else:
            found[lane.lane] = replace(lane, waiting=row.number, oldest=(now - row.oldest).total_seconds())
    return list(found.values())


def has_key(connection: Connection, key: str) -> bool:
    """Return whether any fit was stored with this idempotency key, as it is stored."""
    return connection.execute(select(fits.c.id).where(fits.c.key == key)).first() is not None


def page(connection: Connection, wanted: Page, owner: str) -> list[Row[Any]]:
    """Return the rows of a page of fits of an owner, without results."""
    small = [column for column in fits.c if column.name not in {"result", "progress"}]
    where: list[ColumnElement[bool]] = [fits.c.whole.is_(None), fits.c.owner == owner]
    if wanted.status is not None:
        where.append(fits.c.status == wanted.status)
    if wanted.before is not None:
        created, fit_id = wanted.before
        where.append((fits.c.created < created) | ((fits.c.created == created) & (fits.c.id < fit_id)))
    query = select(*small, null().label("result")).where(*where).order_by(fits.c.created.desc(), fits.c.id.desc())
    return list(connection.execute(query.limit(wanted.limit)))


def progress(connection: Connection, fit_id: str) -> list[dict[str, Any]]:
    """Return the degrees that were reported for a fit."""
    stored = connection.execute(select(fits.c.progress).where(fits.c.id == fit_id)).scalar()
    steps: list[dict[str, Any]] = [] if stored is None else orjson.loads(stored)
    return steps


def sums(connection: Connection, fit_id: str) -> list[bytes]:
    """Return the results of the parts of a fit, in the order of their slices."""
    query = select(fits.c.result).where(fits.c.whole == fit_id, fits.c.status == FitStatus.SUCCESSFUL)
    return list(connection.execute(query.order_by(fits.c.id)).scalars())


def waiting(connection: Connection) -> list[Row[Any]]:
    """Return the rows of fits and parts that wait for a worker, oldest first."""
    query = select(fits).where(*mapping.queued()).order_by(fits.c.created, fits.c.id)
    return list(connection.execute(query))


def has_input(connection: Connection, key: str) -> bool:
    """Return whether any fit has this input."""
    return connection.execute(select(fits.c.id).where(fits.c.input == key).limit(1)).first() is not None


def unused(connection: Connection, keys: Iterable[str]) -> list[str]:
    """Return those of the inputs' keys that no fit has."""
    used = set(connection.execute(select(fits.c.input).distinct()).scalars())
    return [key for key in keys if key not in used]


def outdated(connection: Connection, age: float, size: int | None) -> list[str]:
    """Return ids of fits that ended `age` seconds ago, and then of the oldest beyond `size` bytes of ended fits."""
    ended = [fits.c.status.in_(ENDED), fits.c.whole.is_(None)]  # parts are removed with their fits
    oldest = select(fits.c.id, fits.c.size).where(*ended).order_by(fits.c.finished, fits.c.id).limit(MOST_OUTDATED)
    before = clock(connection) - timedelta(seconds=age)  # by the clock that set `finished`
    found = list(connection.execute(oldest.where(fits.c.finished < before)).scalars())
    if size is None or len(found) == MOST_OUTDATED:
        return found
    young = fits.c.finished >= before
    total = connection.execute(select(func.coalesce(func.sum(fits.c.size), 0)).where(*ended, young)).scalar_one()
    for row in connection.execute(oldest.where(young)):
        if total <= size:
            break
        found.append(row.id)
        total -= row.size
    return found
