"""The route of a fit's zero set."""

from fastapi import APIRouter, Request, Response

from service.api import negotiation
from service.api.answers import phase
from service.api.callers import CallerDep
from service.api.dependencies import ContextDep
from service.api.file_response import known_response
from service.api.fragments import IF_NONE_MATCH, RANGE, ZERO_SET_FILES, ZERO_SET_HEADERS, problems
from service.api.parameters import Bounds, Extent, FitId, Resolution, ZeroSetFormatName, corners
from service.api.presence import while_present
from service.api.representation import zero_set_response
from service.jobs.mesh_request import MeshRequest

router = APIRouter(prefix="/v1/fits", tags=["fits"])


@router.get(
    "/{fit_id}/mesh",
    summary="Take the zero set",
    response_class=Response,
    openapi_extra={"parameters": [IF_NONE_MATCH, RANGE]},
    responses={
        200: {"description": "The zero set, as a file.", "content": ZERO_SET_FILES, "headers": ZERO_SET_HEADERS},
        206: {"description": "A range of its bytes.", "content": ZERO_SET_FILES},
        304: {"description": "Unchanged."},
        **problems(404, 406, 409, 413, 416, 422, 503),
    },
)
async def mesh(  # noqa: PLR0913, PLR0917 - one parameter each in the OpenAPI document
    request: Request,
    context: ContextDep,
    caller: CallerDep,
    fit_id: FitId,
    format: ZeroSetFormatName = None,  # noqa: A002 - the contract's name
    resolution: Resolution = None,
    bounds: Bounds = None,
    extent: Extent = "data",
) -> Response:
    """Return the zero set of a successful fit: a mesh in 3D, polylines in 2D, in the caller's coordinates.

    Vertices lie on f = 0 to rounding; faces look outward, away from f < 0. A file that was asked for before is sent
    again without being made again.
    """
    files = context.files
    fit = await context.fits.get(caller, fit_id)
    dimension = fit.input.dimension
    chosen = negotiation.zero_set_format(request, dimension, format)
    context.limits.check_resolution(resolution, dimension)
    box = None if bounds is None else corners(bounds, dimension)
    wanted = MeshRequest(chosen.name, resolution, box, extent == "data")
    name = files.zero_set_name(fit, wanted)
    if (known := known_response(request, name)) is not None:
        return known
    with phase(request, "mesh"):
        made = files.zero_set(caller, fit, wanted, negotiation.content_encoding(request))
        file = await while_present(request, made)
    return zero_set_response(request, fit, chosen, file, name)
