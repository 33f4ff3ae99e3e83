"""Errors as problem details (RFC 9457), and the one table from exceptions to types of problems."""

import logging
from collections.abc import Iterable
from http import HTTPStatus
from math import ceil
from typing import Annotated, Any

import orjson
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from service.api.answers import ids
from service.api.methods import allowed
from service.api.rate_limit import rate_limit_fields
from service.api.schema_types import JsonPointer, Name, RequestId, Text, TraceId, printable
from service.choices import OneOf
from service.jobs import errors
from service.jobs.bounds import LONGEST_ROOT_PATH
from service.problem_types import PROBLEM_TYPES, ProblemType

logger = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
# Types of problems with which a request is answered whose body may not have been read to its end.
_UNREAD = {"too-large", "unauthorized", "quota-exceeded", "queue-full"}
# Faults that are reported of one request, at most.
MOST_FAULTS = 10

# Exception and type. The first row that matches counts, so subclasses stand before their base classes.
TABLE: tuple[tuple[type[Exception], str], ...] = (
    (errors.MalformedInputError, "malformed-input"),
    (errors.TooLargeError, "too-large"),
    (errors.InvalidInputError, "invalid-input"),
    (errors.FitNotFoundError, "fit-not-found"),
    (errors.FitNotFinishedError, "fit-not-finished"),
    (errors.FitWithoutResultError, "fit-without-result"),
    (errors.DeadlineExceededError, "deadline-exceeded"),
    (errors.OutOfMemoryError, "out-of-memory"),
    (errors.WorkerCrashedError, "worker-crashed"),
    (errors.UnauthorizedError, "unauthorized"),
    (errors.QuotaExceededError, "quota-exceeded"),
    (errors.KeyReusedError, "key-reused"),
    (errors.QueueFullError, "queue-full"),
    (errors.ShuttingDownError, "shutting-down"),
    (errors.NotReadyError, "not-ready"),
)


class Fault(BaseModel):
    """One thing that is wrong, and where."""

    detail: Text = Field(description="What is wrong.")
    pointer: JsonPointer | None = Field(None, description="Where in the JSON body: a JSON pointer (RFC 6901).")
    parameter: Name | None = Field(None, description="Which query parameter or header.")


class Problem(BaseModel):
    """An error, as RFC 9457 problem details."""

    type: str = Field(
        max_length=LONGEST_ROOT_PATH + 100,
        pattern="^.*/problems/[a-z-]+$",
        description="The address of the page about this kind of problem, `/problems/{code}` of this server.",
        examples=["/problems/queue-full"],
    )
    code: Annotated[str, OneOf(PROBLEM_TYPES)] = Field(description="The stable name of the kind.")
    title: Name = Field(description="The kind in words.")
    status: int = Field(ge=400, le=599, description="The HTTP status.")
    detail: Text = Field(description="What went wrong this time.")
    errors: list[Fault] = Field(default_factory=list, max_length=MOST_FAULTS, description="Each single fault.")
    trace_id: TraceId | None = Field(None, description="The trace of the request (W3C), which the server's log names.")
    request_id: RequestId | None = Field(None, description="The request's id, which the server's log names, too.")


class HeaderError(Exception):
    """A header of the request cannot be read."""

    def __init__(self, name: str, detail: str) -> None:
        """Take the name of the header, and what is wrong."""
        super().__init__(detail)
        self.name = name


def response(
    request: Request,
    code: str,
    detail: str,
    faults: Iterable[Fault] = (),
    headers: dict[str, str] | None = None,
) -> Response:
    """Return a response with problem details."""
    kind, own = PROBLEM_TYPES[code], dict(headers or {})
    assert kind.status is not None  # noqa: S101 - the type of a failed fit is answered to no request
    if kind.retry_after is not None:
        own.setdefault("Retry-After", str(kind.retry_after))
    body = as_dict(kind, detail, root_path(request)) | {
        "errors": [fault.model_dump(exclude_none=True) for fault in faults],
        "trace_id": ids(request).trace_id,
        "request_id": ids(request).request_id,
    }
    return Response(orjson.dumps(body), kind.status, own, MEDIA_TYPE)


def as_dict(kind: ProblemType, detail: str, root: str) -> dict[str, Any]:
    """Return the members of problem details that say what kind of problem it is."""
    status = kind.status or HTTPStatus.INTERNAL_SERVER_ERROR
    return {
        "type": kind.path(root),
        "code": kind.code,
        "title": kind.title,
        "status": int(status),
        "detail": printable(detail),
    }


def root_path(request: Request) -> str:
    """Return the prefix that a reverse proxy removes from paths."""
    root: str = request.scope.get("app_root_path", request.scope.get("root_path", ""))
    return root


def install(app: FastAPI) -> None:
    """Let the application answer every error with problem details."""
    app.add_exception_handler(errors.JobError, _job_error)
    app.add_exception_handler(HeaderError, _malformed_header)
    app.add_exception_handler(RequestValidationError, _invalid_request)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(ClientDisconnect, _gone)
    app.add_exception_handler(MemoryError, _out_of_memory)
    app.add_exception_handler(Exception, _unexpected)


def _job_error(request: Request, error: Exception) -> Response:
    code = next(code for kind, code in TABLE if isinstance(error, kind))
    at = getattr(error, "at", ())
    faults = [_fault(request, str(error), at)] if at else []
    if PROBLEM_TYPES[code].status is HTTPStatus.SERVICE_UNAVAILABLE:
        logger.warning("%s: %s", code, error, exc_info=error.__cause__)
    headers = {}
    if isinstance(error, errors.QueueFullError | errors.QuotaExceededError):
        headers["Retry-After"] = str(ceil(error.retry_after))
    if isinstance(error, errors.QuotaExceededError):
        headers |= rate_limit_fields(error.allowances)
    if isinstance(error, errors.UnauthorizedError):
        headers["WWW-Authenticate"] = "Bearer"
    if code in _UNREAD:  # else the server would read the rest of the body, however long it is
        headers["Connection"] = "close"
    return response(request, code, str(error), faults, headers)


def _fault(request: Request, detail: str, at: tuple[str | int, ...]) -> Fault:
    """Return a fault: in the query, if a part of its place is the name of a query parameter, else in the body."""
    named = next((part for part in at if part in request.query_params), None)
    if named is not None:
        return Fault(detail=detail, parameter=str(named))
    return Fault(detail=detail, pointer=errors.json_pointer(at))


def _gone(request: Request, _error: Exception) -> Response:
    """Answer a caller who closed the connection while sending the body; the response is not read by anybody."""
    return response(request, "incomplete-request", "the connection was closed by the caller")


def _malformed_header(request: Request, error: Exception) -> Response:
    assert isinstance(error, HeaderError)  # noqa: S101 - narrows the type
    return response(request, "malformed-header", str(error), [Fault(detail=str(error), parameter=error.name)])


def _invalid_request(request: Request, error: Exception) -> Response:
    """Answer a request whose query parameters or headers are not valid."""
    assert isinstance(error, RequestValidationError)  # noqa: S101 - as above
    faults = [
        Fault(detail=str(one["msg"]), parameter=(".".join(map(str, one["loc"][1:])) or str(one["loc"][0]))[:100])
        for one in error.errors()[:MOST_FAULTS]
    ]
    detail = "; ".join(f"{fault.parameter}: {fault.detail}" for fault in faults)
    return response(request, "invalid-parameter", detail, faults)


def _http_error(request: Request, error: Exception) -> Response:
    """Answer a request that the framework refuses: an unknown path, a wrong method, and others."""
    assert isinstance(error, HTTPException)  # noqa: S101 - as above
    status = HTTPStatus(error.status_code)
    details = {
        HTTPStatus.NOT_FOUND: f"there is nothing at {request.url.path[:200]}",
        HTTPStatus.METHOD_NOT_ALLOWED: f"{request.url.path[:200]} does not answer to {request.method}",
    }
    code = status.phrase.lower().replace(" ", "-").replace("'", "")
    headers = dict(error.headers or {})
    if status is HTTPStatus.METHOD_NOT_ALLOWED:
        headers["Allow"] = ", ".join(sorted(allowed(request.scope)))
    return response(request, code, details.get(status, str(error.detail)), headers=headers)


def _out_of_memory(request: Request, _error: Exception) -> Response:
    logger.warning("the server has no memory for a request (IPFIT_SERVER_MEMORY)")
    return response(request, "out-of-memory", "the server has no memory for this request at the moment")


def _unexpected(request: Request, error: Exception) -> Response:
    logger.error("unexpected error", exc_info=error)
    return response(request, "internal", "The server failed in an unexpected way; its log says more under these ids.")
