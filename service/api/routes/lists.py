"""The route that lists fits."""

from urllib.parse import urlencode

from fastapi import APIRouter, Request, Response

from service.api.callers import CallerDep
from service.api.dependencies import ContextDep
from service.api.fragments import IF_NONE_MATCH, problems
from service.api.parameters import Cursor, Limit, Status
from service.api.problems import root_path
from service.api.representation import list_response
from service.api.schemas import FitList
from service.jobs.page import Page

router = APIRouter(prefix="/v1/fits", tags=["fits"])


@router.get(
    "",
    summary="List fits",
    openapi_extra={"parameters": [IF_NONE_MATCH]},
    responses={200: {"model": FitList}, 304: {"description": "Unchanged."}, **problems(422, 503)},
)
async def list_fits(  # noqa: PLR0913, PLR0917 - as for the mesh
    request: Request,
    context: ContextDep,
    caller: CallerDep,
    status: Status = None,
    limit: Limit = 20,
    cursor: Cursor = None,
) -> Response:
    """Return fits without their results, the newest first, in pages; `next`, and a Link header, lead to the next page.

    A page does not change when newer fits come.
    """
    page = Page.of(limit, status, cursor)
    fits = await context.fits.listed(caller, page)
    if len(fits) < limit:
        return list_response(request, fits, None)
    query = {"status": status, "limit": limit, "cursor": page.cursor(fits[-1])}
    following = urlencode({name: value for name, value in query.items() if value is not None})
    return list_response(request, fits, f"{root_path(request)}/v1/fits?{following}")
