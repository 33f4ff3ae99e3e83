"""The OpenAPI document: FastAPI's, with the models of bodies that no route declares, and our own errors."""

from typing import Any, Literal

from fastapi import FastAPI
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema
from starlette.types import ASGIApp

from service.api.answers import Answers
from service.api.callback_schemas import FitEnded
from service.api.problems import MEDIA_TYPE, Problem
from service.api.schemas import FitRequest, PointSet

# Those that no route declares.
MODELS: tuple[type[BaseModel], ...] = (FitRequest, Problem, FitEnded)
_REF = "#/components/schemas/{model}"


class DocumentedApp(FastAPI):
    """An application whose OpenAPI document describes bodies that routes read themselves, and problem details."""

    def build_middleware_stack(self) -> ASGIApp:
        """Return the application with its middleware, in `Answers`: outside of what answers unexpected errors, too."""
        return Answers(super().build_middleware_stack())

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        if self.openapi_schema is None:
            document = super().openapi()
            models_wanted: list[tuple[type[BaseModel], Literal["validation", "serialization"]]] = [
                *((one, "validation") for one in MODELS),
                (PointSet, "serialization"),
            ]
            _, models = models_json_schema(models_wanted, ref_template=_REF)
            schemas = document["components"]["schemas"]
            schemas.update(models["$defs"])
            for operation in (operation for path in document["paths"].values() for operation in path.values()):
                _describe_problems(operation["responses"])
            _remove_unused(document)
        assert self.openapi_schema is not None  # noqa: S101 - FastAPI stores what it returned
        return self.openapi_schema


def reference(name: str) -> dict[str, str]:
    """Return a reference to a schema of the document."""
    return {"$ref": _REF.format(model=name)}


def problem(description: str) -> dict[str, Any]:
    """Return the description of an error response."""
    return {"description": description, "content": {MEDIA_TYPE: {"schema": reference("Problem")}}}


def _describe_problems(responses: dict[str, Any]) -> None:
    """Replace FastAPI's model of a validation error by `Problem`, and add the response to any other error."""
    if "HTTPValidationError" in str(responses.get("422")):
        responses["422"] = problem("A parameter has a value that is not allowed.")
    responses.setdefault("default", problem("Any other error."))


def _remove_unused(document: dict[str, Any]) -> None:
    """Remove the schemas that nothing refers to, such as FastAPI's own models of errors."""
    schemas: dict[str, Any] = document["components"]["schemas"]
    while unused := [name for name in schemas if _REF.format(model=name) not in _references(document)]:
        for name in unused:
            del schemas[name]


def _references(part: object) -> set[str]:
    """Return the target of every `$ref` in a part of a JSON document."""
    if isinstance(part, list):
        return set().union(*map(_references, part))
    if not isinstance(part, dict):
        return set()
    own = {part["$ref"]} if isinstance(part.get("$ref"), str) else set()
    return own.union(*map(_references, part.values()))
