"""Fits as rows, and the conditions on rows that the store uses again and again."""

from typing import Any

import orjson
from sqlalchemy import ColumnElement, Connection, Row, func, select, update

from service.jobs.fit import Failure, Fit, FitStatus, PointSetRef
from service.jobs.requested_options import RequestedOptions
from service.jobs.slices import Frame, Slice
from service.store.schema import fits


def held(fit_id: str, attempt: int) -> list[ColumnElement[bool]]:
    """Return the conditions that an attempt holds a fit."""
    return [fits.c.id == fit_id, fits.c.attempt == attempt, fits.c.status == FitStatus.RUNNING]


def in_line() -> list[ColumnElement[bool]]:
    """Return the conditions that a fit waits for a worker, and not for its parts."""
    return [fits.c.status == FitStatus.ACCEPTED, fits.c.unsummed == 0]


def written(connection: Connection, where: list[ColumnElement[bool]], **values: object) -> bool:
    """Change the fit that meets the conditions; return whether there was one."""
    return bool(connection.execute(update(fits).where(*where).values(**values)).rowcount)


def backlog(connection: Connection) -> tuple[int, float]:
    """Return how many fits wait in line, with all of their parts or some, and the seconds that these will take."""
    whole = func.coalesce(fits.c.whole, fits.c.id)
    query = select(func.count(whole.distinct()), func.coalesce(func.sum(fits.c.cost), 0.0)).where(*in_line())
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
        "options": orjson.dumps(fit.requested.given),
        "client": fit.client,
        "cost": fit.cost,
        "key": fit.key,
        "payload": fit.payload,
        "created": fit.created,
        "touched": fit.created,
        "parts": fit.parts,
        "unsummed": fit.unsummed,
        "whole": fit.whole,
        "slice": None if fit.slice is None else orjson.dumps(fit.slice).decode(),
    }


def to_fit(row: Row[Any]) -> Fit:
    """Return the fit of a row."""
    return Fit(
        id=row.id,
        status=row.status,
        input=PointSetRef(row.input, row.dimension, row.points, row.size - len(row.result or b"")),
        requested=RequestedOptions(orjson.loads(row.options)),
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
        parts=row.parts,
        unsummed=row.unsummed,
        whole=row.whole,
        slice=None if row.slice is None else _slice(orjson.loads(row.slice)),
    )


def _slice(kept: dict[str, Any]) -> Slice:
    centre, scale = kept["frame"]["centre"], kept["frame"]["scale"]
    return Slice(kept["first"], kept["last"], Frame(tuple(centre), scale))
