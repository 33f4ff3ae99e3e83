"""Questions about stored fits that change nothing."""

from collections.abc import Iterable
from dataclasses import replace
from datetime import timedelta
from typing import Any

import orjson
from sqlalchemy import Connection, Row, func, select

from service.jobs.fit import Fit, FitStatus
from service.store import mapping, outbox
from service.store.schema import fits
from service.store.transitions import clock

ENDED = [status for status in FitStatus if status.final]


def fit(connection: Connection, fit_id: str) -> Fit | None:
    """Return a fit with its callback, or None."""
    row = connection.execute(select(fits).where(fits.c.id == fit_id)).one_or_none()
    return None if row is None else replace(mapping.to_fit(row), callback=outbox.of_fit(connection, fit_id))


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


def outdated(connection: Connection, age: float, size: int) -> list[str]:
    """Return the ids of fits that ended `age` seconds ago, and of the oldest beyond `size` bytes of ended fits."""
    newest_first = func.sum(fits.c.size).over(order_by=(fits.c.finished.desc(), fits.c.id))
    ended = select(fits.c.id, fits.c.finished, newest_first.label("total"))
    each = ended.where(fits.c.status.in_(ENDED), fits.c.whole.is_(None)).subquery()  # parts are removed with their fits
    before = clock(connection) - timedelta(seconds=age)  # by the clock that set `finished`
    too_much = (each.c.finished < before) | (each.c.total > size)
    return list(connection.execute(select(each.c.id).where(too_much).order_by(each.c.finished)).scalars())
