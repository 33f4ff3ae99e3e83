"""The route of a fit's zero set."""

from fastapi import APIRouter, Request, Response

from service.api import negotiation
from service.api.dependencies import ContextDep
from service.api.fragments import ZERO_SET_FILES, ZERO_SET_HEADERS, problems
from service.api.parameters import Bounds, Extent, FitId, Resolution, ZeroSetFormatName, corners
from service.api.representation import zero_set_response
from service.jobs.mesh_request import MeshRequest

router = APIRouter(prefix="/v1/fits", tags=["fits"])


@router.get(
    "/{fit_id}/mesh",
    summary="Take the zero set",
    response_class=Response,
    responses={
        200: {"description": "The zero set, as a file.", "content": ZERO_SET_FILES, "headers": ZERO_SET_HEADERS},
        **problems(404, 406, 409, 422, 503),
    },
)
async def mesh(  # noqa: PLR0913, PLR0917 - one parameter each in the OpenAPI document
    request: Request,
    context: ContextDep,
    fit_id: FitId,
    format: ZeroSetFormatName = None,  # noqa: A002 - the contract's name
    resolution: Resolution = None,
    bounds: Bounds = None,
    extent: Extent = "data",
) -> Response:
    """Return the zero set of a successful fit: a mesh in 3D, polylines in 2D, in the caller's coordinates.

    Vertices lie on f = 0 to rounding; faces look outward, away from f < 0.
    """
    fit = await context.fits.get(fit_id)
    dimension = fit.input.dimension
    chosen = negotiation.zero_set_format(request, dimension, format)
    context.limits.check_resolution(resolution, dimension)
    box = None if bounds is None else corners(bounds, dimension)
    file = await context.fits.zero_set(fit_id, MeshRequest(chosen.name, resolution, box, extent == "data"))
    return zero_set_response(fit_id, chosen, file)
