"""Fits as rows, and the conditions on rows that the store uses again and again."""

from typing import Any

import orjson
from sqlalchemy import ColumnElement, Connection, Row, func, select, update

from service.jobs.fit import Failure, Fit, FitStatus, PointSetRef
from service.store.tables import fits


def held(fit_id: str, attempt: int) -> list[ColumnElement[bool]]:
    """Return the conditions that an attempt holds a fit."""
    return [fits.c.id == fit_id, fits.c.attempt == attempt, fits.c.status == FitStatus.RUNNING]


def written(connection: Connection, where: list[ColumnElement[bool]], **values: object) -> bool:
    """Change the fit that meets the conditions; return whether there was one."""
    return bool(connection.execute(update(fits).where(*where).values(**values)).rowcount)


def backlog(connection: Connection) -> tuple[int, float]:
    """Return how many fits wait, and the seconds that they will take together."""
    query = select(func.count(), func.coalesce(func.sum(fits.c.cost), 0.0)).where(fits.c.status == FitStatus.ACCEPTED)
    count, cost = connection.execute(query).one()
    return int(count), float(cost)


def from_fit(fit: Fit) -> dict[str, Any]:
    """Return the row of a new fit."""
    return {
        "id": fit.id,
        "status": fit.status,
        "input": fit.input.key,
        "dimension": fit.input.dimension,
        "points": fit.input.points,
        "size": fit.input.size,
        "options": orjson.dumps(fit.options),
        "client": fit.client,
        "cost": fit.cost,
        "key": fit.key,
        "payload": fit.payload,
        "created": fit.created,
        "touched": fit.created,
    }


def to_fit(row: Row[Any]) -> Fit:
    """Return the fit of a row."""
    return Fit(
        id=row.id,
        status=row.status,
        input=PointSetRef(row.input, row.dimension, row.points, row.size - len(row.result or b"")),
        options=orjson.loads(row.options),
        created=row.created,
        client=row.client,
        cost=row.cost,
        key=row.key,
        payload=row.payload,
        started=row.started,
        finished=row.finished,
        attempt=row.attempt,
        crashes=row.crashes,
        result=row.result,
        failure=None if row.failure is None else Failure(**orjson.loads(row.failure)),
    )
