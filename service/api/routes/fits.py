"""The routes of fits: POST one, read it, dismiss it."""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.api import body, negotiation
from service.api.callback_fragment import FIT_ENDED
from service.api.dependencies import ContextDep
from service.api.fragments import (
    IDEMPOTENCY_KEY,
    IF_NONE_MATCH,
    POINT_SET_BODY,
    PREFER,
    ZERO_SET_FILES,
    ZERO_SET_HEADERS,
    problems,
)
from service.api.parameters import NO_OPTIONS, FitId, FitQuery, client_address, idempotency_key
from service.api.preferences import DEFAULT_WAIT, Preferences
from service.api.representation import fit_path, fit_response, zero_set_response
from service.api.schemas import FitResource
from service.jobs.mesh_request import MeshRequest
from service.options import requested

router = APIRouter(prefix="/v1/fits", tags=["fits"])


@router.post(
    "",
    summary="Fit a point set",
    openapi_extra={
        "parameters": [PREFER, IDEMPOTENCY_KEY],
        "requestBody": POINT_SET_BODY,
        "callbacks": {"fitEnded": {"{$request.query.callback}": {"post": FIT_ENDED}}},
    },
    responses={
        200: {
            "model": FitResource,
            "description": "The fit has ended.",
            "content": ZERO_SET_FILES,
            "headers": ZERO_SET_HEADERS,
        },
        202: {"model": FitResource, "description": "Accepted; see Location."},
        **problems(400, 406, 409, 413, 415, 422, 503),
    },
)
async def create(request: Request, context: ContextDep, query: Annotated[FitQuery, Query()]) -> Response:
    """Take a point set, fit it in a worker, and answer with the fit.

    Waits up to `Prefer: wait=N` seconds (30 if not said); after that, or at once with `Prefer: respond-async`, the
    answer is 202 with the fit's Location. With an Accept header for a zero-set file, the file is the answer. Options
    stand in the JSON body or in the query; the query wins.
    """
    fits, limits = context.fits, context.limits
    sent = negotiation.point_set_format(request, query.format)
    async with body.received(request, limits.body_bytes, context.incoming) as content:
        points = await fits.read(content, sent, columns=query.columns, missing=query.missing)
    options = requested(points.options, query.model_dump(exclude_unset=True, exclude=NO_OPTIONS))
    options = limits.capped(points.dimension, options)
    plan = fits.plan(points, options)
    limits.check_system(points, plan)
    wanted = negotiation.wanted_file(request, points.dimension)
    sender, key = client_address(request), idempotency_key(request)
    fit = await fits.accept(points, options, plan, sender, key, callback=query.callback)
    preferences = Preferences.of(request)
    seconds = preferences.seconds(DEFAULT_WAIT, limits.wait)
    fit = await fits.get(fit.id, seconds)
    headers = {"Location": fit_path(request, fit.id), **preferences.applied(seconds)}
    if not fit.status.final:
        return fit_response(request, fit, await fits.progress(fit), HTTPStatus.ACCEPTED, headers)
    if wanted is not None:
        return zero_set_response(fit.id, wanted, await fits.zero_set(fit.id, MeshRequest(wanted.name)), headers)
    return fit_response(request, fit, [], headers=headers)


@router.get(
    "/{fit_id}",
    summary="Look at a fit",
    openapi_extra={"parameters": [PREFER, IF_NONE_MATCH]},
    responses={200: {"model": FitResource}, 304: {"description": "Unchanged."}, **problems(404)},
)
async def read(request: Request, context: ContextDep, fit_id: FitId) -> Response:
    """Return a fit; with `Prefer: wait=N`, after at most N seconds if it is still live."""
    preferences = Preferences.of(request)
    seconds = preferences.seconds(0.0, context.limits.wait)
    fit = await context.fits.get(fit_id, seconds)
    return fit_response(request, fit, await context.fits.progress(fit), headers=preferences.applied(seconds))


@router.delete(
    "/{fit_id}",
    summary="Dismiss or remove a fit",
    responses={
        200: {"model": FitResource, "description": "It was live and is dismissed now."},
        204: {"description": "It had ended and is removed now."},
        **problems(404),
    },
)
async def dismiss(request: Request, context: ContextDep, fit_id: FitId) -> Response:
    """Dismiss a live fit, killing the process that works on it; or remove one that has ended, with its points."""
    fit = await context.fits.dismiss(fit_id)
    return Response(status_code=HTTPStatus.NO_CONTENT) if fit is None else fit_response(request, fit, [])
