"""The catalogue of problem types: the pages to which the `type` of problem details leads."""

from html import escape
from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import HTMLResponse, JSONResponse
from starlette.exceptions import HTTPException

from service.api import negotiation
from service.api.fragments import problems
from service.api.parameters import ProblemCode
from service.api.problems import root_path
from service.api.schemas import ProblemKind, ProblemKindList
from service.problem_types import PROBLEM_TYPES, ProblemType

router = APIRouter(prefix="/problems", tags=["problems"])
_HEADERS = {"Cache-Control": "max-age=3600", "Vary": "Accept"}
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title} – ipfit</title></head>
<body><h1>{title}</h1><p><code>{code}</code>{status}</p><p>{remedy}</p>
<p><a href="{root}/problems">All problem types</a></p></body></html>
"""


@router.get("", summary="List the problem types", responses={200: {"model": ProblemKindList}})
async def list_problem_types(request: Request) -> Response:
    """Return every type of problem that an answer or a failed fit can name."""
    kinds = [_members(kind, root_path(request)) for kind in PROBLEM_TYPES.values()]
    return JSONResponse({"problems": kinds}, headers=_HEADERS)


@router.get("/{code}", summary="Explain a problem type", responses={200: {"model": ProblemKind}, **problems(404)})
async def explain_problem_type(request: Request, code: ProblemCode) -> Response:
    """Return what a type of problem means and what helps, as JSON, or as a page for a browser."""
    kind = PROBLEM_TYPES.get(code)
    if kind is None:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    accept = request.headers.get("accept", "*/*")
    if negotiation.quality(accept, "text/html") > negotiation.quality(accept, "application/json"):
        return HTMLResponse(_page(kind, root_path(request)), headers=_HEADERS)
    return JSONResponse(_members(kind, root_path(request)), headers=_HEADERS)


def _members(kind: ProblemType, root: str) -> dict[str, Any]:
    """Return the members of `ProblemKind`."""
    return {
        "type": kind.path(root),
        "code": kind.code,
        "title": kind.title,
        "status": None if kind.status is None else int(kind.status),
        "remedy": kind.remedy,
    }


def _page(kind: ProblemType, root: str) -> str:
    status = "" if kind.status is None else f", answered with {int(kind.status)} {kind.status.phrase}"
    return _PAGE.format(
        title=escape(kind.title), code=kind.code, status=escape(status), remedy=escape(kind.remedy), root=escape(root)
    )
