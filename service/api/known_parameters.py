"""Query parameters: those that the OpenAPI document lists for the operation, each at most once."""

from collections import Counter

from fastapi import Request
from fastapi.exceptions import RequestValidationError


def refuse_unknown_parameters(request: Request) -> None:
    """Refuse a query with a parameter that the operation does not have, or that stands there twice.

    A misspelt parameter that is ignored would change the answer unnoticed; of two values, each reader takes another.

    Raises
    ------
    RequestValidationError
        If there is one; it names them.

    """
    given = Counter(name for name, _ in request.query_params.multi_items())
    if not given:
        return
    known = _known(request)
    faults = [
        _fault(name, f"unknown parameter; known are {', '.join(known) or 'none'}") for name in given.keys() - {*known}
    ]
    faults += [_fault(name, f"is given {count} times") for name, count in given.items() if count > 1 and name in known]
    if faults:
        raise RequestValidationError(sorted(faults, key=lambda fault: fault["loc"]))


def _known(request: Request) -> list[str]:
    """Return the names of the operation's query parameters."""
    path = getattr(request.scope.get("route"), "path_format", "")
    operation = request.app.openapi()["paths"].get(path, {}).get(request.method.lower(), {})
    return [one["name"] for one in operation.get("parameters", ()) if one["in"] == "query"]


def _fault(name: str, message: str) -> dict[str, object]:
    return {"type": "query", "loc": ("query", name), "msg": message, "input": None}
