"""Parts of the OpenAPI document that FastAPI cannot derive from the signatures of the routes."""

from typing import Any

from service.api.openapi import problem, reference
from service.api.parameters import LONGEST_KEY
from service.api.representation import ZERO_SET_WARNING
from service.jobs.media_types import JSON, POINT_SET_FORMATS, ZERO_SET_FORMATS

BINARY: dict[str, Any] = {"schema": {"type": "string", "format": "binary"}}
# The content of a response with the file of a zero set.
ZERO_SET_FILES: dict[str, Any] = {name: BINARY for known in ZERO_SET_FORMATS for name in known.media_types}
# The content of a response with a point set.
POINT_SET_FILES: dict[str, Any] = {
    known.media_type: {"schema": reference("PointSet")} if known is JSON else BINARY for known in POINT_SET_FORMATS
}
# The headers of a response with the file of a zero set.
ZERO_SET_HEADERS: dict[str, Any] = {
    ZERO_SET_WARNING: {
        "description": "Only with a zero set as a file, and only if the grid was too coarse for it: a sentence that "
        "says how much of the zero set is thinner than four cells of the grid, and what helps.",
        "schema": {"type": "string"},
    }
}

PREFER = {
    "name": "Prefer",
    "in": "header",
    "description": "`wait=N`: answer after at most N seconds. `respond-async`: answer at once (RFC 7240).",
    "schema": {"type": "string"},
    "examples": {"wait": {"value": "wait=10"}, "at once": {"value": "respond-async"}},
}
IF_NONE_MATCH = {
    "name": "If-None-Match",
    "in": "header",
    "description": "The ETag of an earlier answer: 304 if nothing has changed.",
    "schema": {"type": "string"},
}
IF_MATCH = {
    "name": "If-Match",
    "in": "header",
    "description": "The ETag of the state in which the fit must be: 412 if it has changed since.",
    "schema": {"type": "string"},
}
IDEMPOTENCY_KEY = {
    "name": "Idempotency-Key",
    "in": "header",
    "description": "A unique text in double quotes. A request that is sent again with the same key gets the fit of the "
    "first; with the same key and another point set, other options or another callback, 422.",
    "schema": {"type": "string", "minLength": 3, "maxLength": 2 * LONGEST_KEY + 2},
    "example": '"8e03978e-40d5-43dd-bc93-6894a57f9324"',
}
RANGE = {
    "name": "Range",
    "in": "header",
    "description": "One range of bytes, such as `bytes=0-1023`: 206 with these bytes.",
    "schema": {"type": "string"},
}
RATE_LIMIT = {
    "RateLimit": {
        "description": "What is left of each quota: `r` fits now; after `t` seconds there will be more.",
        "schema": {"type": "string"},
    },
    "RateLimit-Policy": {
        "description": "The quotas: `waiting` fits at once, and `hourly` fits.",
        "schema": {"type": "string"},
    },
}
REPLAYED = {
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
        known.media_type: {"schema": reference("FitRequest")} if known is JSON else BINARY
        for known in POINT_SET_FORMATS
    },
}

_PROBLEMS: dict[int | str, dict[str, Any]] = {
    400: problem("The body is not what its media type says."),
    401: problem("The server has API keys, and the request none of them."),
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
