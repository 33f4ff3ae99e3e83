"""What the OpenAPI document says once for all operations: servers, tags, links, and the errors that each may have."""

from collections.abc import Iterable, Iterator
from typing import Any

from service.api.descriptions import problem, reference
from service.api.fragments import FIT_HEADERS, RETRY_AFTER_HEADER
from service.jobs.bounds import MOST_BODY_BYTES
from service.options import FitOptions

TAGS = [
    {"name": "fits", "description": "Fits: a point set goes in, a polynomial and its zero set come out."},
    {"name": "health", "description": "Whether the server is alive and ready, for its supervisor."},
    {"name": "problems", "description": "The types of errors, and what helps."},
]
CONTACT = {"name": "ipfit contributors"}
# Errors that any request may have, whatever its path: status, name, description.
ERRORS = (
    (400, "BadRequest", "The request is not HTTP as it should be, or its body is not what its media type says."),
    (408, "RequestTimeout", "The request arrived too slowly."),
    (431, "HeadTooLarge", "The request's line and headers are over 64 kB or 256 fields."),
    (500, "InternalError", "The server failed in an unexpected way."),
    (503, "Unavailable", "The server is stopping, its store fails, or too many connections are open."),
)
# Errors that any request may have which needs an API key.
CALLERS_ERRORS = (
    (401, "Unauthorized", "The server has API keys, and the request none of them."),
    (429, "QuotaExceeded", "A quota of the caller is used up; RateLimit has what is left."),
)
# operationId, and what can be done with the fit that a response holds
_NEXT = {
    "read": "Look at the fit.",
    "dismiss": "Dismiss or remove the fit.",
    "mesh": "Take the zero set of the fit.",
}


def complete(document: dict[str, Any]) -> None:
    """Add to a document what holds for all of its operations."""
    document["info"].setdefault("contact", CONTACT)
    document.setdefault("servers", servers(""))
    document.setdefault("tags", TAGS)
    components = document["components"]
    components["schemas"]["ZeroSetFile"] = {
        "description": "The bytes of a file.",
        "type": "string",
        "format": "binary",
        "maxLength": MOST_BODY_BYTES,
    }
    components["responses"] = {
        name: _with_retry(status, problem(text)) for status, name, text in ERRORS + CALLERS_ERRORS
    }
    for operation in (operation for path in document["paths"].values() for operation in path.values()):
        errors = ERRORS + CALLERS_ERRORS if operation.setdefault("security", []) else ERRORS
        _complete_responses(operation["responses"], errors)
    for name, schema in _option_schemas(document):
        _tell_default(name, schema)
    _add_integer_formats(document)


def servers(root_path: str) -> list[dict[str, Any]]:
    """Return the one server of the document: that which it is read from, behind this prefix."""
    return [
        {"url": root_path or "/", "description": "This server, be it for tests or in production.", "x-internal": False}
    ]


def _complete_responses(responses: dict[str, Any], errors: Iterable[tuple[int, str, str]]) -> None:
    """Describe errors as problems, and what a response with a fit has beside it; add the errors that all have."""
    if "HTTPValidationError" in str(responses.get("422")):
        responses["422"] = problem("A parameter has a value that is not allowed.")
    for code, response in responses.items():
        _with_retry(int(code), response)
        if response.get("content", {}).get("application/json") == {"schema": reference("FitResource")}:
            response["headers"] = {**FIT_HEADERS, **response.get("headers", {})}
            response["links"] = {name: _link(name, text) for name, text in _NEXT.items()}
    for status, name, _ in errors:
        responses.setdefault(str(status), {"$ref": f"#/components/responses/{name}"})
    for code in sorted(responses):
        responses[code] = responses.pop(code)


def _link(operation: str, text: str) -> dict[str, Any]:
    return {"operationId": operation, "parameters": {"fit_id": "$response.body#/id"}, "description": text}


def _with_retry(status: int, response: dict[str, Any]) -> dict[str, Any]:
    """Return the description of a response, with the header that says when to try again if it may have it."""
    if status in (409, 429, 503):
        response["headers"] = {**RETRY_AFTER_HEADER, **response.get("headers", {})}
    return response


def _option_schemas(document: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the name and every description of each option of a fit: as a member of the body and in the query."""
    properties = document["components"]["schemas"]["FitOptions"]["properties"]
    yield from properties.items()
    for operation in (operation for path in document["paths"].values() for operation in path.values()):
        for parameter in operation.get("parameters", ()):
            if parameter["in"] == "query" and parameter["name"] in properties:
                yield parameter["name"], parameter
                yield parameter["name"], parameter["schema"]


def _tell_default(name: str, described: dict[str, Any]) -> None:
    """Say in words what the default of an option is.

    Generated clients send what `default` says, with every request. But a preset has other defaults, and an option that
    has no effect beside the others is refused.
    """
    default = FitOptions.model_fields[name].default
    described.pop("default", None)
    if default is not None:
        described["description"] += f" Default: `{str(default).lower() if isinstance(default, bool) else default}`."


def _add_integer_formats(document: dict[str, Any]) -> None:
    """Say of every integer within 32 bits that it is; generated clients then have a type for it."""
    for schema in _objects(document):
        if schema.get("type") == "integer" and schema.get("maximum", 2**31) < 2**31:
            schema["format"] = "int32"


def _objects(part: object) -> Iterator[dict[str, Any]]:
    """Yield every object in a part of a JSON document."""
    if isinstance(part, dict):
        yield part
    for member in part.values() if isinstance(part, dict) else part if isinstance(part, list) else ():
        yield from _objects(member)
