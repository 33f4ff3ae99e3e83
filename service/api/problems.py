"""Errors as problem details (RFC 9457), and the one table from exceptions to HTTP statuses."""

import logging
import re
from collections.abc import Iterable
from http import HTTPStatus
from math import ceil
from typing import Any
from uuid import uuid4

import orjson
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.routing import BaseRoute, Match, Mount

from service.jobs import errors

logger = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
# Seconds after which a caller may try again, by type of problem.
RETRY_AFTER = {"fit-not-finished": "1", "shutting-down": "10", "not-ready": "10", "worker-crashed": "1"}
# Faults that are reported of one request, at most.
MOST_FAULTS = 10
METHODS = ("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS")
_TRACEPARENT = re.compile(r"[0-9a-f]{2}-([0-9a-f]{32})-[0-9a-f]{16}-[0-9a-f]{2}")

# Exception, status, type, title. The first row that matches counts, so subclasses stand before their base classes.
TABLE: tuple[tuple[type[Exception], HTTPStatus, str, str], ...] = (
    (errors.MalformedInputError, HTTPStatus.BAD_REQUEST, "malformed-input", "The body cannot be read"),
    (errors.TooLargeError, HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "too-large", "Over a limit of this server"),
    (errors.InvalidInputError, HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-input", "The request cannot be carried out"),
    (errors.FitNotFoundError, HTTPStatus.NOT_FOUND, "fit-not-found", "No such fit"),
    (errors.FitNotFinishedError, HTTPStatus.CONFLICT, "fit-not-finished", "The fit has not ended yet"),
    (errors.FitWithoutResultError, HTTPStatus.CONFLICT, "fit-without-result", "The fit ended without a result"),
    (errors.DeadlineExceededError, HTTPStatus.SERVICE_UNAVAILABLE, "deadline-exceeded", "The work took too long"),
    (errors.OutOfMemoryError, HTTPStatus.SERVICE_UNAVAILABLE, "out-of-memory", "The work needs too much memory"),
    (errors.WorkerCrashedError, HTTPStatus.SERVICE_UNAVAILABLE, "worker-crashed", "A worker died doing the work"),
    (errors.KeyReusedError, HTTPStatus.UNPROCESSABLE_ENTITY, "key-reused", "The key came with another payload"),
    (errors.QueueFullError, HTTPStatus.SERVICE_UNAVAILABLE, "queue-full", "Too many fits wait"),
    (errors.ShuttingDownError, HTTPStatus.SERVICE_UNAVAILABLE, "shutting-down", "The server is stopping"),
    (errors.NotReadyError, HTTPStatus.SERVICE_UNAVAILABLE, "not-ready", "The server is not ready"),
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
    """Return a response with problem details."""
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
    """Return the trace id that the caller sent (W3C traceparent), or a new one; it stays the same for the request."""
    if not hasattr(request.state, "trace_id"):
        sent = _TRACEPARENT.fullmatch(request.headers.get("traceparent", ""))
        request.state.trace_id = sent.group(1) if sent else uuid4().hex
    return str(request.state.trace_id)


def install(app: FastAPI) -> None:
    """Let the application answer every error with problem details."""
    app.add_exception_handler(errors.JobError, _job_error)
    app.add_exception_handler(RequestValidationError, _invalid_request)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(ClientDisconnect, _gone)
    app.add_exception_handler(Exception, _unexpected)


def _job_error(request: Request, error: Exception) -> Response:
    status, kind, title = next(row[1:] for row in TABLE if isinstance(error, row[0]))
    at = getattr(error, "at", ())
    faults = [_fault(request, str(error), at)] if at else []
    if status >= HTTPStatus.INTERNAL_SERVER_ERROR:
        logger.warning("%s: %s (trace %s)", kind, error, trace_id(request), exc_info=error.__cause__)
    headers = {"Retry-After": RETRY_AFTER[kind]} if kind in RETRY_AFTER else {}
    if isinstance(error, errors.QueueFullError):
        headers["Retry-After"] = str(ceil(error.retry_after))
    if kind == "too-large":  # else the server would read the rest of the body, however long it is
        headers["Connection"] = "close"
    return response(request, status, kind, str(error), faults, title=title, headers=headers)


def _fault(request: Request, detail: str, at: tuple[str | int, ...]) -> Fault:
    """Return a fault: in the query, if a part of its place is the name of a query parameter, else in the body."""
    named = next((part for part in at if part in request.query_params), None)
    if named is not None:
        return Fault(detail=detail, parameter=str(named))
    return Fault(detail=detail, pointer=errors.json_pointer(at))


def _gone(request: Request, _error: Exception) -> Response:
    """Answer a caller who closed the connection while sending the body; the response is not read by anybody."""
    return response(request, HTTPStatus.BAD_REQUEST, "incomplete-request", "the connection was closed by the caller")


def _invalid_request(request: Request, error: Exception) -> Response:
    """Answer a request whose query parameters or headers are not valid."""
    assert isinstance(error, RequestValidationError)  # noqa: S101 - narrows the type
    faults = [
        Fault(detail=str(one["msg"]), parameter=(".".join(map(str, one["loc"][1:])) or str(one["loc"][0]))[:100])
        for one in error.errors()[:MOST_FAULTS]
    ]
    detail = "; ".join(f"{fault.parameter}: {fault.detail}" for fault in faults)
    return response(request, HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-parameter", detail, faults)


def _http_error(request: Request, error: Exception) -> Response:
    """Answer a request that the framework refuses: an unknown path, a wrong method, and others."""
    assert isinstance(error, HTTPException)  # noqa: S101 - as above
    status = HTTPStatus(error.status_code)
    details = {
        HTTPStatus.NOT_FOUND: f"there is nothing at {request.url.path[:200]}",
        HTTPStatus.METHOD_NOT_ALLOWED: f"{request.url.path[:200]} does not answer to {request.method}",
    }
    kind = status.phrase.lower().replace(" ", "-").replace("'", "")
    headers = dict(error.headers or {})
    if status is HTTPStatus.METHOD_NOT_ALLOWED:
        headers["Allow"] = ", ".join(sorted(_allowed(request)))
    return response(request, status, kind, details.get(status, str(error.detail)), headers=headers)


def _allowed(request: Request) -> set[str]:
    """Return all methods of the path; the framework names only those of the first route that matches."""
    # The original scope: routers have changed that of the request before the error.
    scope = {**request.scope, "root_path": request.scope.get("app_root_path", "")}
    allowed = {method for method in METHODS if _answers(request.app.routes, scope | {"method": method})}
    return allowed | {"HEAD"} if "GET" in allowed else allowed  # see `service.api.head`


def _answers(routes: list[BaseRoute], scope: dict[str, Any]) -> bool:
    """Return whether a route takes this method at this path. Mounted files take GET and HEAD only."""
    matching = (route for route in routes if route.matches(scope)[0] is Match.FULL)
    return any(scope["method"] in ("GET", "HEAD") or not isinstance(route, Mount) for route in matching)


def _unexpected(request: Request, error: Exception) -> Response:
    logger.error("unexpected error, trace %s", trace_id(request), exc_info=error)
    detail = "The server failed in an unexpected way; its log says more under this trace id."
    return response(request, HTTPStatus.INTERNAL_SERVER_ERROR, "internal", detail)
