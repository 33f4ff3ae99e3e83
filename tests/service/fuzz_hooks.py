"""Hooks of schemathesis: it sends npy files, some of its point sets can be fitted, and it knows what DELETE does."""

import random
from http import HTTPStatus
from typing import Any

import schemathesis
from pydantic import JsonValue
from schemathesis import Case, CheckContext, GenerationMode, HookContext, Response
from schemathesis.openapi.checks import UseAfterFree
from schemathesis.specs.openapi.checks import use_after_free

POINTS: JsonValue = [[1, 0], [0.7, 0.7], [0, 1], [-0.7, 0.7], [-1, 0], [-0.7, -0.7], [0, -1], [0.7, -0.7]]

schemathesis.serializer.alias("application/x-npy", "application/octet-stream")


@schemathesis.hook
def before_call(context: HookContext, case: Case[Any], kwargs: dict[str, Any]) -> None:  # noqa: ARG001 - schemathesis's
    """Put a circle in place of most valid point sets: random ones are refused, and links lead on from fits."""
    valid = case.meta is not None and case.meta.generation.mode is GenerationMode.POSITIVE
    if valid and case.operation.label == "POST /v1/fits" and random.random() < 0.8:  # noqa: S311 - no secret
        case.body, case.media_type = {"points": POINTS, "options": {"max_degree": 2}}, "application/json"
        case.query = {}
        case.headers.pop("Idempotency-Key", None)


@schemathesis.check
def use_after_removal(ctx: CheckContext, response: Response, case: Case[Any]) -> bool | None:
    """Stand in for `use_after_free`: a fit is gone after a DELETE with 204, but not after one that dismissed it."""
    try:
        return use_after_free(ctx, response, case)
    except UseAfterFree as failure:
        deleted = ctx.internals.find_response(case_id=failure.deleted_case_id or "")
        if deleted is not None and deleted.status_code == HTTPStatus.OK:
            return None
        raise
