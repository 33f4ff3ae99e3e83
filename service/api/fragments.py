"""Parts of the OpenAPI document that FastAPI cannot derive from the signatures of the routes."""

from typing import Any

from service.api.descriptions import problem, reference
from service.api.parameters import LONGEST_KEY
from service.api.representation import ZERO_SET_WARNING
from service.jobs.bounds import HEAD_BYTES, LONGEST_ROOT_PATH, MOST_BODY_BYTES
from service.jobs.media_types import JSON, POINT_SET_FORMATS, ZERO_SET_FORMATS

# What an HTTP field may hold, within the limit of a request's head.
_FIELD: dict[str, Any] = {"type": "string", "maxLength": HEAD_BYTES, "pattern": r"^[\t\x20-\x7e\x80-\xff]*$"}
_SECONDS: dict[str, Any] = {"type": "integer", "minimum": 0, "maximum": 86400}

_POINT_SET_FILE: dict[str, Any] = {"schema": {"type": "string", "format": "binary", "maxLength": MOST_BODY_BYTES}}
# The content of a response with the file of a zero set.
ZERO_SET_FILES: dict[str, Any] = {
    name: {"schema": reference("CurveFeature" if known.name == "geojson" else "ZeroSetFile")}
    for known in ZERO_SET_FORMATS
    for name in known.media_types
}
# The content of a response with a point set.
POINT_SET_FILES: dict[str, Any] = {
    known.media_type: {"schema": reference("PointSet")} if known is JSON else _POINT_SET_FILE
    for known in POINT_SET_FORMATS
}
# The headers of a response with the file of a zero set.
ZERO_SET_HEADERS: dict[str, Any] = {
    ZERO_SET_WARNING: {
        "description": "Only with a zero set as a file, and only if the grid was too coarse for it: a sentence that "
        "says how much of the zero set is thinner than four cells of the grid, and what helps.",
        "schema": _FIELD,
    }
}
# When to come back: with a fit that is live, and with errors that pass.
RETRY_AFTER_HEADER: dict[str, Any] = {
    "Retry-After": {"description": "Seconds after which to ask again; not with what has ended.", "schema": _SECONDS}
}
_PATH: dict[str, Any] = {"type": "string", "format": "uri-reference", "maxLength": LONGEST_ROOT_PATH + 100}
# The headers of a response with a fit.
FIT_HEADERS: dict[str, Any] = {
    **RETRY_AFTER_HEADER,
    "ETag": {
        "description": "The version of the fit, for If-None-Match.",
        "schema": {"type": "string", "pattern": '^"[0-9a-f]{32}"$', "maxLength": 34},
    },
    "Content-Location": {"description": "The path of the fit.", "schema": _PATH},
    "Preference-Applied": {
        "description": "What was done of what Prefer asked for.",
        "schema": {
            "type": "string",
            "pattern": "^(respond-async|wait=[0-9]+|respond-async, wait=[0-9]+)$",
            "maxLength": 100,
        },
    },
}
# The headers of every answer to a point set that was accepted.
ACCEPTED_HEADERS: dict[str, Any] = {"Location": {"description": "The path of the fit.", "schema": _PATH}}

PREFER = {
    "name": "Prefer",
    "in": "header",
    "description": "`wait=N`: answer after at most N seconds. `respond-async`: answer at once (RFC 7240).",
    "schema": _FIELD,
    "examples": {"wait": {"value": "wait=10"}, "at once": {"value": "respond-async"}},
}
IF_NONE_MATCH = {
    "name": "If-None-Match",
    "in": "header",
    "description": "The ETag of an earlier answer: 304 if nothing has changed.",
    "schema": _FIELD,
}
IF_MATCH = {
    "name": "If-Match",
    "in": "header",
    "description": "The ETag of the state in which the fit must be: 412 if it has changed since.",
    "schema": _FIELD,
}
IDEMPOTENCY_KEY = {
    "name": "Idempotency-Key",
    "in": "header",
    "description": "A unique text in double quotes. A request that is sent again with the same key gets the fit of the "
    "first; with the same key and another point set, other options or another callback, 422.",
    "schema": {
        "type": "string",
        "minLength": 3,
        "maxLength": LONGEST_KEY + 2,
        "pattern": r'^"[\x20-\x21\x23-\x5b\x5d-\x7e]+"$',
    },
    "example": '"8e03978e-40d5-43dd-bc93-6894a57f9324"',
}
RANGE = {
    "name": "Range",
    "in": "header",
    "description": "One range of bytes, such as `bytes=0-1023`: 206 with these bytes.",
    "schema": _FIELD,
}
RATE_LIMIT: dict[str, Any] = {
    "RateLimit": {
        "description": "What is left of each quota: `r` fits now; after `t` seconds there will be more.",
        "schema": _FIELD,
    },
    "RateLimit-Policy": {
        "description": "The quotas: `waiting` fits at once, and `hourly` fits.",
        "schema": _FIELD,
    },
}
REPLAYED: dict[str, Any] = {
    "Idempotency-Replayed": {
        "description": "`true` if an earlier request with the same Idempotency-Key made the fit.",
        "schema": {"type": "string", "enum": ["true"]},
    }
}
POINT_SET_BODY = {
    "required": True,
    "description": "JSON; or an npy file or a CSV table of N rows, whose columns a header or `columns` names. "
    "Without names, 2 or 3 columns are points, and 4 or 6 are points and outward normals of one length.",
    "content": {
        known.media_type: {"schema": reference("FitRequest")} if known is JSON else _POINT_SET_FILE
        for known in POINT_SET_FORMATS
    },
}

_PROBLEMS: dict[int | str, dict[str, Any]] = {
    400: problem("The body is not what its media type says."),
    404: problem("There is no such fit."),
    406: problem("The zero set cannot be had in that format."),
    409: problem("The fit has not ended, or ended without a result."),
    412: problem("The fit is not in the state that If-Match names."),
    413: problem("The body, the points or the system are over a limit of this server."),
    416: problem("The range lies outside of the file."),
    415: problem("The body is of a media type or an encoding that is not read here."),
    422: problem("The point set cannot be fitted, or an option or a parameter has a value that is not allowed."),
    429: problem("A quota of the caller is used up; RateLimit has what is left."),
    503: problem("The server is stopping, its queue is full, its store fails, or the work took too long."),
}


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the descriptions of the error responses with these statuses."""
    return {status: _PROBLEMS[status] for status in statuses}
