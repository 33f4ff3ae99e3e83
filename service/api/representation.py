"""Responses with fits, as JSON, or with a zero set, as a file."""

from collections.abc import Sequence
from http import HTTPStatus
from typing import Any

import orjson
from fastapi import Request, Response

from service.api import preconditions, problems
from service.api.file_response import file_response
from service.api.json_response import json_response
from service.jobs.callback import Callback
from service.jobs.exported_file import ExportedFile
from service.jobs.fit import Fit
from service.jobs.media_types import PointSetFormat, ZeroSetFormat
from service.jobs.warning_codes import with_codes
from service.problem_types import PROBLEM_TYPES

ZERO_SET_WARNING = "Zero-Set-Warning"  # the header that says that the grid of a zero set was too coarse
# A fit is stored by its caller only, who asks each time whether it has changed.
ASK_AGAIN = {"Cache-Control": "private, no-cache"}


def fit_response(
    request: Request,
    fit: Fit,
    progress: list[dict[str, Any]],
    status: HTTPStatus = HTTPStatus.OK,
    headers: dict[str, str] | None = None,
) -> Response:
    """Return a response with a fit as JSON and a strong ETag; 304 if the caller has it already."""
    sent = {"Content-Location": fit_path(request, fit.id), **ASK_AGAIN, **(headers or {})}
    if not fit.status.final:
        sent["Retry-After"] = "1"
    return json_response(request, _json(as_dict(fit, progress, problems.root_path(request))), sent, status)


def check_match(request: Request, fit: Fit, progress: list[dict[str, Any]]) -> None:
    """Check that If-Match, if the request has one, names the present state of the fit."""
    preconditions.check_match(
        request, preconditions.strong_etag(_json(as_dict(fit, progress, problems.root_path(request))))
    )


def list_response(request: Request, fits: Sequence[Fit], following: str | None) -> Response:
    """Return a response with a page of fits, without their results, and the address of the `following` page."""
    root = problems.root_path(request)
    body = _json({"fits": [summary(fit, root) for fit in fits], "next": following})
    return json_response(request, body, ASK_AGAIN | ({"Link": f'<{following}>; rel="next"'} if following else {}))


def _json(members: dict[str, Any]) -> bytes:
    return orjson.dumps(members, option=orjson.OPT_UTC_Z)


def fit_path(request: Request, fit_id: str) -> str:
    """Return the path of a fit as the caller knows it: behind a proxy that removes a prefix, it begins with that."""
    return f"{problems.root_path(request)}/v1/fits/{fit_id}"


def points_response(request: Request, fit: Fit, sent: PointSetFormat, file: ExportedFile, name: str) -> Response:
    """Return the file of a point set, which is called `name`, as a response."""
    return file_response(request, file, name, sent.media_type, _file_name(fit, sent.name))


def zero_set_response(  # noqa: PLR0913, PLR0917 - the parts of the response
    request: Request,
    fit: Fit,
    sent: ZeroSetFormat,
    file: ExportedFile,
    name: str,
    headers: dict[str, str] | None = None,
) -> Response:
    """Return the file of a zero set, which is called `name`, as a response; its warning stands in a header."""
    named = _file_name(fit, sent.name) | (headers or {})
    if file.warning is not None:
        named[ZERO_SET_WARNING] = file.warning
    return file_response(request, file, name, sent.media_types[0], named)


def _file_name(fit: Fit, ending: str) -> dict[str, str]:
    return {"Content-Disposition": f'inline; filename="{fit.id}.{ending}"'}


def as_dict(fit: Fit, progress: list[dict[str, Any]], root: str = "") -> dict[str, Any]:
    """Return the members of `FitResource` that this fit has, for a server under the path `root`."""
    members = summary(fit, root)
    if not fit.status.final:
        members["progress"] = progress
    if fit.parts and not fit.status.final:
        members["parts"] = {"summed": fit.parts - fit.unsummed, "total": fit.parts}
    if fit.result is not None:
        result = orjson.loads(fit.result)
        members |= result | {"warnings": with_codes(result["warnings"])}
    return members


def summary(fit: Fit, root: str) -> dict[str, Any]:
    """Return the members of `FitSummary`."""
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
    if fit.failure is not None:
        members["problem"] = problems.as_dict(PROBLEM_TYPES[fit.failure.kind], fit.failure.detail, root)
    return members


def _callback(callback: Callback) -> dict[str, Any]:
    """Return the members of `CallbackResource`."""
    return {
        "url": callback.shown_url,
        "state": callback.state,
        "tries": callback.tries,
        "last_error": callback.last_error,
    }
