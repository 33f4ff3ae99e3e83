"""Fits: POST one, look at it, take its zero set, dismiss it."""

from http import HTTPStatus
from math import isfinite
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query, Request, Response
from pydantic import Field

from service import options
from service.api import body, negotiation
from service.api.dependencies import Context, Here
from service.api.openapi import problem, reference
from service.api.preferences import DEFAULT_WAIT, Preferences
from service.api.representation import fit_response
from service.api.schemas import FitResource
from service.jobs.errors import InvalidInputError
from service.jobs.media_types import FILES, MeshRequest, ZeroSetFormat

router = APIRouter(prefix="/v1/fits", tags=["fits"])

FitId = Annotated[str, Path(description="The id that POST /v1/fits gave.")]
_FILES: dict[str, Any] = {
    name: {"schema": {"type": "string", "format": "binary"}} for k in FILES for name in k.media_types
}
_PROBLEMS: dict[int | str, dict[str, Any]] = {
    400: problem("The body is not what its media type says."),
    404: problem("There is no such fit."),
    406: problem("The zero set cannot be had in that format."),
    409: problem("The fit has not ended, or ended without a result."),
    413: problem("The body, the points or the system are over a limit of this server."),
    415: problem("The body is of a media type or an encoding that is not read here."),
    422: problem("The point set cannot be fitted, or an option or a parameter has a value that is not allowed."),
    503: problem("The server is stopping, its queue is full, its store fails, or the work took too long."),
}


def _problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    return {status: _PROBLEMS[status] for status in statuses}


class FitQuery(options.FitOptions):
    """Options in the query, and what the body is."""

    format: Literal["json", "npy"] | None = Field(None, description="What the body is; wins over Content-Type.")


_PREFER = {
    "name": "Prefer",
    "in": "header",
    "description": "`wait=N`: answer after at most N seconds. `respond-async`: answer at once (RFC 7240).",
    "schema": {"type": "string"},
    "examples": {"wait": {"value": "wait=10"}, "at once": {"value": "respond-async"}},
}
_IF_NONE_MATCH = {
    "name": "If-None-Match",
    "in": "header",
    "description": "The ETag of an earlier answer: 304 if nothing has changed.",
    "schema": {"type": "string"},
}
LONGEST_KEY = 200
_KEY = {
    "name": "Idempotency-Key",
    "in": "header",
    "description": "Any unique text. A request that is sent again with the same key gets the fit of the first; with "
    "the same key and another point set or other options, 422.",
    "schema": {"type": "string", "maxLength": LONGEST_KEY},
}
_BODY = {
    "parameters": [_PREFER, _KEY],
    "requestBody": {
        "required": True,
        "description": "JSON, or an npy file of N rows: 2 or 3 columns are points, 4 or 6 points and outward normals.",
        "content": {
            "application/json": {"schema": reference("FitRequest")},
            "application/x-npy": {"schema": {"type": "string", "format": "binary"}},
        },
    },
}


@router.post(
    "",
    summary="Fit a point set",
    openapi_extra=_BODY,
    responses={
        200: {"model": FitResource, "description": "The fit has ended.", "content": _FILES},
        202: {"model": FitResource, "description": "Accepted; see Location."},
        **_problems(400, 406, 409, 413, 415, 422, 503),
    },
)
async def create(request: Request, here: Here, query: Annotated[FitQuery, Query()]) -> Response:
    """Take a point set, fit it in a worker, and answer with the fit.

    Waits up to `Prefer: wait=N` seconds (30 if not said); after that, or at once with `Prefer: respond-async`, the
    answer is 202 with the fit's Location. With an Accept header for a zero-set file, the file is the answer. Options
    stand in the JSON body or in the query; the query wins.
    """
    kind = negotiation.point_set_kind(request, query.format)
    async with body.received(request, here.limits.body_bytes, here.incoming) as content:
        points = await here.desk.read(content, kind)
    requested = options.requested(points.options, query.model_dump(exclude_unset=True, exclude={"format"}))
    requested = here.limits.capped(points.dimension, requested)
    plan = here.desk.plan(points, requested)
    here.limits.check_system(points, plan)
    wanted = negotiation.file_kind(request, points.dimension) if negotiation.wants_file(request) else None
    fit = await here.desk.accept(points, requested, plan, _client(request), _key(request))
    preferences = Preferences.of(request)
    seconds = preferences.seconds(DEFAULT_WAIT, here.limits.wait)
    fit = await here.desk.get(fit.id, seconds)
    headers = {"Location": f"/v1/fits/{fit.id}", **preferences.applied(seconds)}
    if not fit.status.final:
        return fit_response(request, fit, await here.desk.progress(fit), HTTPStatus.ACCEPTED, headers)
    if wanted is not None:
        return await _file(here, fit.id, wanted, MeshRequest(wanted.name), headers)
    return fit_response(request, fit, [], headers=headers)


@router.get(
    "/{fit_id}",
    summary="Look at a fit",
    openapi_extra={"parameters": [_PREFER, _IF_NONE_MATCH]},
    responses={200: {"model": FitResource}, 304: {"description": "Unchanged."}, **_problems(404)},
)
async def read(request: Request, here: Here, fit_id: FitId) -> Response:
    """Return a fit; with `Prefer: wait=N`, after at most N seconds if it is still live."""
    preferences = Preferences.of(request)
    seconds = preferences.seconds(0.0, here.limits.wait)
    fit = await here.desk.get(fit_id, seconds)
    return fit_response(request, fit, await here.desk.progress(fit), headers=preferences.applied(seconds))


@router.get(
    "/{fit_id}/mesh",
    summary="Take the zero set",
    response_class=Response,
    responses={
        200: {"description": "The zero set, as a file.", "content": _FILES},
        **_problems(404, 406, 409, 422, 503),
    },
)
async def mesh(  # noqa: PLR0913, PLR0917 - one parameter each in the OpenAPI document
    request: Request,
    here: Here,
    fit_id: FitId,
    format: Annotated[  # noqa: A002 - the contract's name
        Literal["glb", "ply", "stl", "obj", "svg", "geojson"] | None,
        Query(description="The file kind; wins over Accept. 3D: glb, ply, stl, obj. 2D: svg, geojson."),
    ] = None,
    resolution: Annotated[int | None, Query(ge=4, description="Grid points along the longest axis.")] = None,
    bounds: Annotated[
        str | None,
        Query(
            description="Lower, then upper corner: 4 (2D) or 6 (3D) numbers with commas between, caller's coordinates. "
            "Default: the fit's own bounds.",
            examples=["-1,-1,1,1"],
        ),
    ] = None,
    extent: Annotated[
        Literal["data", "bounds"],
        Query(description="`data` leaves out what lies away from the points; `bounds` keeps everything in the bounds."),
    ] = "data",
) -> Response:
    """Return the zero set of a successful fit: a mesh in 3D, polylines in 2D, in the caller's coordinates.

    Vertices lie on f = 0 to rounding; faces look outward, away from f < 0.
    """
    fit = await here.desk.get(fit_id)
    dimension = fit.input.dimension
    kind = negotiation.file_kind(request, dimension, format)
    here.limits.check_resolution(resolution, dimension)
    box = None if bounds is None else _corners(bounds, dimension)
    return await _file(here, fit_id, kind, MeshRequest(kind.name, resolution, box, extent == "data"))


@router.delete(
    "/{fit_id}",
    summary="Dismiss or remove a fit",
    responses={
        200: {"model": FitResource, "description": "It was live and is dismissed now."},
        204: {"description": "It had ended and is removed now."},
        **_problems(404),
    },
)
async def dismiss(request: Request, here: Here, fit_id: FitId) -> Response:
    """Dismiss a live fit, killing the process that works on it; or remove one that has ended, with its points."""
    fit = await here.desk.dismiss(fit_id)
    return Response(status_code=HTTPStatus.NO_CONTENT) if fit is None else fit_response(request, fit, [])


async def _file(
    here: Context, fit_id: str, kind: ZeroSetFormat, drawing: MeshRequest, headers: dict[str, str] | None = None
) -> Response:
    content = await here.desk.draw(fit_id, drawing)
    named = {"Content-Disposition": f'inline; filename="{fit_id}.{kind.name}"', "Vary": "Accept", **(headers or {})}
    return Response(content, headers=named, media_type=kind.media_types[0])


def _client(request: Request) -> str:
    """Return who asks, as far as is known: the address that the connection comes from."""
    return request.client.host if request.client is not None else ""


def _key(request: Request) -> str | None:
    """Return the idempotency key.

    Raises
    ------
    InvalidInputError
        If it is empty or too long.

    """
    key = request.headers.get("idempotency-key")
    if key is not None and not 0 < len(key) <= LONGEST_KEY:
        raise InvalidInputError(f"an Idempotency-Key has 1 to {LONGEST_KEY} characters")
    return key


def _corners(bounds: str, dimension: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return lower and upper corner from `x,y,…,X,Y,…`."""
    try:
        numbers = tuple(float(part) for part in bounds.split(","))
    except ValueError:
        numbers = ()
    lower, upper = numbers[:dimension], numbers[dimension:]
    ordered = len(upper) == dimension and all(a < b for a, b in zip(lower, upper, strict=True))
    if not ordered or not all(map(isfinite, numbers)):
        raise InvalidInputError(
            f"bounds must be {2 * dimension} finite numbers with commas between, every lower one below its upper one",
            ("bounds",),
        )
    return lower, upper
