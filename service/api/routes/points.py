"""The route of a fit's points."""

from fastapi import APIRouter, Request, Response

from service.api import negotiation
from service.api.callers import CallerDep
from service.api.dependencies import ContextDep
from service.api.file_response import known_response
from service.api.fragments import IF_NONE_MATCH, POINT_SET_FILES, RANGE, problems
from service.api.parameters import FitId, PointSetFormatName
from service.api.presence import while_present
from service.api.representation import points_response

router = APIRouter(prefix="/v1/fits", tags=["fits"])


@router.get(
    "/{fit_id}/points",
    summary="Take the points",
    response_class=Response,
    openapi_extra={"parameters": [IF_NONE_MATCH, RANGE]},
    responses={
        200: {"description": "The point set.", "content": POINT_SET_FILES},
        206: {"description": "A range of its bytes.", "content": POINT_SET_FILES},
        304: {"description": "Unchanged."},
        **problems(404, 406, 416, 422, 503),
    },
)
async def points(
    request: Request,
    context: ContextDep,
    caller: CallerDep,
    fit_id: FitId,
    format: PointSetFormatName = None,  # noqa: A002 - the contract's name
) -> Response:
    """Return the points of a fit, and their unit normals if they came with normals, as they were accepted.

    `POST /v1/fits` takes each of the formats again.
    """
    fit = await context.fits.get(caller, fit_id)
    chosen = negotiation.returned_point_set_format(request, format)
    name = f"{fit.input.key} {chosen.name}"
    if (known := known_response(request, name)) is not None:
        return known
    made = context.files.points(caller, fit, chosen.name, negotiation.content_encoding(request))
    return points_response(request, fit, chosen, await while_present(request, made), name)
