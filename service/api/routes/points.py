"""The route of a fit's points."""

from fastapi import APIRouter, Request, Response

from service.api import negotiation
from service.api.dependencies import ContextDep
from service.api.fragments import POINT_SET_FILES, problems
from service.api.parameters import FitId, PointSetFormatName
from service.api.representation import points_response

router = APIRouter(prefix="/v1/fits", tags=["fits"])


@router.get(
    "/{fit_id}/points",
    summary="Take the points",
    response_class=Response,
    responses={
        200: {"description": "The point set.", "content": POINT_SET_FILES},
        304: {"description": "Unchanged."},
        **problems(404, 406, 422, 503),
    },
)
async def points(
    request: Request,
    context: ContextDep,
    fit_id: FitId,
    format: PointSetFormatName = None,  # noqa: A002 - the contract's name
) -> Response:
    """Return the points of a fit, and their unit normals if they came with normals, as they were accepted.

    `POST /v1/fits` takes each of the formats again.
    """
    fit = await context.fits.get(fit_id)
    chosen = negotiation.returned_point_set_format(request, format)
    content = await context.fits.points(fit, chosen.name)
    return points_response(request, fit, chosen, content)
