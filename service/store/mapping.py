"""Fits as rows of the table, and the conditions on rows that several methods of the store use."""

from typing import Any

import orjson
from sqlalchemy import ColumnElement, Connection, Row, update

from service.jobs.fit import Failure, Fit, FitStatus, PointSetRef
from service.jobs.point_set_summary import PointSetSummary
from service.jobs.requested_options import RequestedOptions
from service.jobs.slices import Frame, Slice
from service.store.schema import fits


def held_by(fit_id: str, attempt: int) -> list[ColumnElement[bool]]:
    """Return the conditions under which this attempt holds the fit."""
    return [fits.c.id == fit_id, fits.c.attempt == attempt, fits.c.status == FitStatus.RUNNING]


def queued() -> list[ColumnElement[bool]]:
    """Return the conditions under which a fit waits for a worker, and not for its parts."""
    return [fits.c.status == FitStatus.ACCEPTED, fits.c.unsummed == 0]


def update_where(connection: Connection, where: list[ColumnElement[bool]], **values: object) -> bool:
    """Change the fit that meets the conditions; return whether there was one."""
    return bool(connection.execute(update(fits).where(*where).values(**values)).rowcount)


def stored_key(owner: str, key: str) -> str:
    """Return the text under which an idempotency key is stored: it belongs to its owner. No key has a line feed."""
    return f"{owner}\n{key}" if owner else key


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
        "owner": fit.owner,
        "cost": fit.cost,
        "key": None if fit.key is None else stored_key(fit.owner, fit.key),
        "payload": fit.payload,
        "created": fit.created,
        "touched": fit.created,
        "parts": fit.parts,
        "unsummed": fit.unsummed,
        "whole": fit.whole,
        "slice": _json(fit.slice),
        "summary": _json(fit.input.summary),
    }


def to_fit(row: Row[Any]) -> Fit:
    """Return the fit of a row."""
    size = row.size - len(row.result or b"")
    summary = None if row.summary is None else _summary(orjson.loads(row.summary))
    return Fit(
        id=row.id,
        status=row.status,
        input=PointSetRef(row.input, row.dimension, row.points, size, summary),
        requested=RequestedOptions(orjson.loads(row.options)),
        created=row.created,
        client=row.client,
        owner=row.owner,
        cost=row.cost,
        key=None if row.key is None else row.key.rpartition("\n")[2],
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


def _json(value: Slice | PointSetSummary | None) -> str | None:
    return None if value is None else orjson.dumps(value).decode()


def _slice(stored: dict[str, Any]) -> Slice:
    return Slice(stored["first"], stored["last"], _frame(stored["frame"]))


def _summary(stored: dict[str, Any]) -> PointSetSummary:
    incomplete = stored.get("incomplete", 0)  # older versions did not store it
    return PointSetSummary(stored["planar"], _frame(stored["frame"]), stored["sha256"], incomplete)


def _frame(stored: dict[str, Any]) -> Frame:
    return Frame(tuple(stored["centre"]), stored["scale"])
