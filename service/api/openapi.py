"""The OpenAPI document: what the framework writes, and the models that no route declares and it does not see."""

from typing import Any

from fastapi import FastAPI
from pydantic.json_schema import models_json_schema

from service.api.problems import MEDIA_TYPE, Problem
from service.api.schemas import FitRequest

_REF = "#/components/schemas/{model}"
# FastAPI adds these to every route with a parameter; here every error is a problem.
_UNUSED = ("HTTPValidationError", "ValidationError")


class DocumentedApp(FastAPI):
    """An application whose document says what its hand-made bodies and errors are."""

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        if self.openapi_schema is None:
            document = super().openapi()
            _, models = models_json_schema([(FitRequest, "validation"), (Problem, "validation")], ref_template=_REF)
            schemas = document["components"]["schemas"]
            schemas.update(models["$defs"])
            for name in _UNUSED:
                schemas.pop(name, None)
            for operation in (operation for path in document["paths"].values() for operation in path.values()):
                _tell_problems(operation["responses"])
        assert self.openapi_schema is not None  # noqa: S101 - FastAPI keeps what it returned
        return self.openapi_schema


def reference(name: str) -> dict[str, str]:
    """Return a reference to a schema of the document."""
    return {"$ref": _REF.format(model=name)}


def problem(description: str) -> dict[str, Any]:
    """Return the description of an error response."""
    return {"description": description, "content": {MEDIA_TYPE: {"schema": reference("Problem")}}}


def _tell_problems(responses: dict[str, Any]) -> None:
    """Replace the framework's idea of a validation error by ours, and say what every route may answer."""
    if "HTTPValidationError" in str(responses.get("422")):
        responses["422"] = problem("A parameter has a value that is not allowed.")
    responses.setdefault("default", problem("Any other error."))
