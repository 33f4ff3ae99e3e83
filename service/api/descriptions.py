"""The smallest parts of the OpenAPI document."""

from typing import Any

from service.api.problems import MEDIA_TYPE

REF = "#/components/schemas/{model}"


def reference(name: str) -> dict[str, str]:
    """Return a reference to a schema of the document."""
    return {"$ref": REF.format(model=name)}


def problem(description: str) -> dict[str, Any]:
    """Return the description of an error response."""
    return {"description": description, "content": {MEDIA_TYPE: {"schema": reference("Problem")}}}
