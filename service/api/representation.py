"""Responses with a fit, as JSON, or with its zero set, as a file."""

import hashlib
from http import HTTPStatus
from typing import Any

import orjson
from fastapi import Request, Response

from service.jobs.callback import Callback
from service.jobs.fit import Fit
from service.jobs.media_types import ZeroSetFormat
from service.jobs.warning_codes import with_codes
from service.jobs.zero_set_file import ZeroSetFile

ZERO_SET_WARNING = "Zero-Set-Warning"  # the header that says that the grid of a zero set was too coarse


def fit_response(
    request: Request,
    fit: Fit,
    progress: list[dict[str, Any]],
    status: HTTPStatus = HTTPStatus.OK,
    headers: dict[str, str] | None = None,
) -> Response:
    """Return a response with a fit as JSON and a strong ETag; 304 if the caller has it already."""
    body = orjson.dumps(as_dict(fit, progress), option=orjson.OPT_UTC_Z)
    etag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
    sent = {"ETag": etag, "Content-Location": fit_path(request, fit.id), **(headers or {})}
    if not fit.status.final:
        sent["Retry-After"] = "1"
    cached = request.headers.get("if-none-match", "")
    if request.method == "GET" and (etag in cached or cached.strip() == "*"):
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=sent)
    return Response(body, status, sent, "application/json")


def fit_path(request: Request, fit_id: str) -> str:
    """Return the path of a fit as the caller knows it: behind a proxy that removes a prefix, it begins with that."""
    root: str = request.scope.get("app_root_path", request.scope.get("root_path", ""))
    return f"{root}/v1/fits/{fit_id}"


def zero_set_response(
    fit_id: str, sent: ZeroSetFormat, file: ZeroSetFile, headers: dict[str, str] | None = None
) -> Response:
    """Return the file of a zero set as a response; its warning stands in a header."""
    named = {"Content-Disposition": f'inline; filename="{fit_id}.{sent.name}"', "Vary": "Accept", **(headers or {})}
    if file.warning is not None:
        named[ZERO_SET_WARNING] = file.warning
    return Response(file.content, headers=named, media_type=sent.media_types[0])


def as_dict(fit: Fit, progress: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the members of `FitResource` that this fit has."""
    members: dict[str, Any] = {
        "id": fit.id,
        "status": fit.status,
        "created": fit.created,
        "started": fit.started,
        "finished": fit.finished,
        "dimension": fit.input.dimension,
        "points": fit.input.points,
        "options": fit.requested.given,
    }
    if fit.callback is not None:
        members["callback"] = _callback(fit.callback)
    if not fit.status.final:
        members["progress"] = progress
    if fit.parts and not fit.status.final:
        members["parts"] = {"summed": fit.parts - fit.unsummed, "total": fit.parts}
    if fit.failure is not None:
        members["problem"] = {
            "type": f"urn:ipfit:problem:{fit.failure.kind}",
            "title": "The fit failed",
            "status": int(HTTPStatus.INTERNAL_SERVER_ERROR),
            "detail": fit.failure.detail,
        }
    if fit.result is not None:
        result = orjson.loads(fit.result)
        members |= result | {"warnings": with_codes(result["warnings"])}
    return members


def _callback(callback: Callback) -> dict[str, Any]:
    """Return the members of `CallbackResource`."""
    return {
        "url": callback.shown_url,
        "state": callback.state,
        "tries": callback.tries,
        "last_error": callback.last_error,
    }
