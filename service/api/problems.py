"""Every error as problem details (RFC 9457), and the one table from exceptions to HTTP."""

import logging
import re
from collections.abc import Iterable
from http import HTTPStatus
from typing import Any
from uuid import uuid4

import orjson
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException

from service.jobs import errors

logger = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
_TRACEPARENT = re.compile(r"[0-9a-f]{2}-([0-9a-f]{32})-[0-9a-f]{16}-[0-9a-f]{2}")

# Exception → (status, type, title). The first that matches counts, so the special stand before the general.
TABLE: tuple[tuple[type[Exception], HTTPStatus, str, str], ...] = (
    (errors.MalformedInputError, HTTPStatus.BAD_REQUEST, "malformed-input", "The body cannot be read"),
    (errors.TooLargeError, HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "too-large", "Over a limit of this server"),
    (errors.InvalidInputError, HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-input", "The request cannot be carried out"),
    (errors.FitNotFoundError, HTTPStatus.NOT_FOUND, "fit-not-found", "No such fit"),
    (errors.FitNotFinishedError, HTTPStatus.CONFLICT, "fit-not-finished", "The fit has not ended yet"),
    (errors.FitWithoutResultError, HTTPStatus.CONFLICT, "fit-without-result", "The fit ended without a result"),
    (errors.DeadlineExceededError, HTTPStatus.SERVICE_UNAVAILABLE, "deadline-exceeded", "The work took too long"),
    (errors.WorkerCrashedError, HTTPStatus.SERVICE_UNAVAILABLE, "worker-crashed", "A worker died doing the work"),
    (errors.ShuttingDownError, HTTPStatus.SERVICE_UNAVAILABLE, "shutting-down", "The server is stopping"),
)


class Fault(BaseModel):
    """One thing that is wrong, and where."""

    detail: str = Field(description="What is wrong.")
    pointer: str | None = Field(None, description="Where in the JSON body: a JSON pointer (RFC 6901).")
    parameter: str | None = Field(None, description="Which query parameter or header.")


class Problem(BaseModel):
    """An error, as RFC 9457 problem details."""

    type: str = Field(description="A stable name of the kind of problem, `urn:ipfit:problem:…`.")
    title: str = Field(description="The kind in words.")
    status: int = Field(description="The HTTP status.")
    detail: str = Field(description="What went wrong this time.")
    errors: list[Fault] = Field(default_factory=list, description="Each single fault.")
    trace_id: str | None = Field(None, description="Names the request in the server's log.")


def response(  # noqa: PLR0913 - the parts of a problem
    request: Request,
    status: HTTPStatus,
    kind: str,
    detail: str,
    faults: Iterable[Fault] = (),
    *,
    title: str | None = None,
    headers: dict[str, str] | None = None,
) -> Response:
    """Return a problem as a response."""
    body: dict[str, Any] = {
        "type": f"urn:ipfit:problem:{kind}",
        "title": title or status.phrase,
        "status": int(status),
        "detail": detail,
        "errors": [fault.model_dump(exclude_none=True) for fault in faults],
        "trace_id": trace_id(request),
    }
    return Response(orjson.dumps(body), status, headers, MEDIA_TYPE)


def trace_id(request: Request) -> str:
    """Return the trace id that the caller sent (W3C traceparent), or a fresh one, the same for the whole request."""
    if not hasattr(request.state, "trace_id"):
        sent = _TRACEPARENT.fullmatch(request.headers.get("traceparent", ""))
        request.state.trace_id = sent.group(1) if sent else uuid4().hex
    return str(request.state.trace_id)


def pointer(at: Iterable[str | int]) -> str:
    """Return a JSON pointer.

    >>> pointer(("points", 17, 1))
    '/points/17/1'
    """
    return "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in at)


def install(app: FastAPI) -> None:
    """Answer every error of this app with a problem."""
    app.add_exception_handler(errors.JobError, _job_error)
    app.add_exception_handler(RequestValidationError, _invalid_request)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(Exception, _unexpected)


def _job_error(request: Request, error: Exception) -> Response:
    status, kind, title = next(row[1:] for row in TABLE if isinstance(error, row[0]))
    at = getattr(error, "at", ())
    faults = [Fault(detail=str(error), pointer=pointer(at))] if at else []
    if kind in ("deadline-exceeded", "worker-crashed"):
        logger.warning("%s: %s (trace %s)", kind, error, trace_id(request))
    headers = {"Retry-After": "1"} if kind == "fit-not-finished" else None
    return response(request, status, kind, str(error), faults, title=title, headers=headers)


def _invalid_request(request: Request, error: Exception) -> Response:
    """Answer for query parameters and headers that do not validate."""
    assert isinstance(error, RequestValidationError)  # noqa: S101 - narrows the type for the reader and for mypy
    faults = [
        Fault(detail=str(one["msg"]), parameter=".".join(str(part) for part in one["loc"][1:]) or str(one["loc"][0]))
        for one in error.errors()
    ]
    detail = "; ".join(f"{fault.parameter}: {fault.detail}" for fault in faults)
    return response(request, HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-parameter", detail, faults)


def _http_error(request: Request, error: Exception) -> Response:
    """Answer for unknown routes, wrong methods and whatever else the framework refuses."""
    assert isinstance(error, HTTPException)  # noqa: S101 - as above
    status = HTTPStatus(error.status_code)
    details = {
        HTTPStatus.NOT_FOUND: f"there is nothing at {request.url.path}",
        HTTPStatus.METHOD_NOT_ALLOWED: f"{request.url.path} does not answer to {request.method}",
    }
    kind = status.phrase.lower().replace(" ", "-").replace("'", "")
    headers = dict(error.headers or {})
    return response(request, status, kind, details.get(status, str(error.detail)), headers=headers)


def _unexpected(request: Request, error: Exception) -> Response:
    logger.error("unexpected error, trace %s", trace_id(request), exc_info=error)
    detail = "The server failed in an unexpected way; its log says more under this trace id."
    return response(request, HTTPStatus.INTERNAL_SERVER_ERROR, "internal", detail)
