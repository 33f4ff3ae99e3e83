"""The OpenAPI document: FastAPI's, with the models of bodies that no route declares, and what holds for all routes."""

from typing import Any, Literal

from fastapi import FastAPI
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema
from starlette.types import ASGIApp

from service.api import whole_document
from service.api.answers import Answers
from service.api.callback_schemas import FitEnded
from service.api.curve_feature import CurveFeature
from service.api.descriptions import REF
from service.api.fit_request import FitRequest
from service.api.interrupted import Interrupted
from service.api.problems import Problem
from service.api.schemas import PointSet

_UNDECLARED: tuple[type[BaseModel], ...] = (FitRequest, CurveFeature, Problem, FitEnded)


class DocumentedApp(FastAPI):
    """An application whose OpenAPI document describes bodies that routes read themselves, and problem details."""

    def build_middleware_stack(self) -> ASGIApp:
        """Return the application with its middleware, in `Answers`: outside of what answers unexpected errors, too."""
        return Answers(Interrupted(super().build_middleware_stack()))

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        if self.openapi_schema is None:
            document = super().openapi()
            wanted: list[tuple[type[BaseModel], Literal["validation", "serialization"]]] = [
                *((model, "validation") for model in _UNDECLARED),
                (PointSet, "serialization"),
            ]
            _, models = models_json_schema(wanted, ref_template=REF)
            document["components"]["schemas"].update(models["$defs"])
            whole_document.complete(document)
            _remove_unused(document)
        assert self.openapi_schema is not None  # noqa: S101 - FastAPI stores what it returned
        return self.openapi_schema


def _remove_unused(document: dict[str, Any]) -> None:
    """Remove the schemas that nothing refers to, such as FastAPI's own models of errors."""
    schemas: dict[str, Any] = document["components"]["schemas"]
    while unused := [name for name in schemas if REF.format(model=name) not in _references(document)]:
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
