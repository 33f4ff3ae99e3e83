"""Query parameters: those that the OpenAPI document lists for the operation, each at most once."""

from collections import Counter
from typing import Any

from fastapi import Request
from fastapi.exceptions import RequestValidationError


async def refuse_unknown_parameters(request: Request) -> None:
    """Refuse a query with a parameter that the operation does not have, or that stands there twice.

    A misspelt parameter that is ignored would change the answer unnoticed; of two values, each reader takes another.

    Raises
    ------
    RequestValidationError
        If there is one; it names them.

    """
    sent = request.query_params.multi_items()
    if not sent:
        return
    given, known = Counter(name for name, _ in sent), _known(request)
    names = [one["name"] for one in known]
    faults = [
        _fault(name, f"unknown parameter; known are {', '.join(names) or 'none'}") for name in given.keys() - {*names}
    ]
    faults += [_fault(name, f"is given {count} times") for name, count in given.items() if count > 1 and name in names]
    numbers = {one["name"] for one in known if _is_number(one["schema"])}
    faults += [
        _fault(name, "must be a number in ASCII digits") for name, text in sent if name in numbers and _is_odd(text)
    ]
    if faults:
        raise RequestValidationError(sorted(faults, key=lambda fault: fault["loc"]))


def _known(request: Request) -> list[dict[str, Any]]:
    """Return the operation's query parameters, as the OpenAPI document describes them."""
    path = getattr(request.scope.get("route"), "path_format", "")
    operation = request.app.openapi()["paths"].get(path, {}).get(request.method.lower(), {})
    return [one for one in operation.get("parameters", ()) if one["in"] == "query"]


def _is_number(schema: dict[str, Any]) -> bool:
    kinds = {one.get("type") for one in schema.get("anyOf", [schema])}
    return not kinds.isdisjoint({"integer", "number"})


def _is_odd(text: str) -> bool:
    """Return whether Python reads more in a text than other languages do: `1_0` and digits of other scripts."""
    return "_" in text or not text.isascii()


def _fault(name: str, message: str) -> dict[str, object]:
    return {"type": "query", "loc": ("query", name), "msg": message, "input": None}
