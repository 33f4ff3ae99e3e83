"""The routes of fits: POST one, read it, dismiss or remove it."""

import asyncio
from http import HTTPStatus
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.api import body, negotiation
from service.api.answers import phase
from service.api.callback_fragment import FIT_ENDED
from service.api.callers import CallerDep
from service.api.dependencies import Context, ContextDep
from service.api.fragments import (
    ACCEPTED_HEADERS,
    IDEMPOTENCY_KEY,
    IF_MATCH,
    IF_NONE_MATCH,
    POINT_SET_BODY,
    PREFER,
    RATE_LIMIT,
    REPLAYED,
    ZERO_SET_FILES,
    ZERO_SET_HEADERS,
    problems,
)
from service.api.parameters import NO_OPTIONS, FitId, FitQuery, Purge, idempotency_key
from service.api.preferences import DEFAULT_WAIT, Preferences
from service.api.presence import while_present
from service.api.rate_limit import rate_limit_fields
from service.api.representation import check_match, fit_path, fit_response, zero_set_response
from service.api.schemas import FitResource
from service.jobs.accepted import Accepted
from service.jobs.caller import Caller
from service.jobs.errors import NotReadyError, QueueFullError
from service.jobs.fit import FitStatus, ReceivedPoints
from service.jobs.media_types import ZeroSetFormat
from service.jobs.mesh_request import MeshRequest
from service.jobs.read_request import ReadRequest
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
            "headers": ACCEPTED_HEADERS | ZERO_SET_HEADERS | REPLAYED | RATE_LIMIT,
        },
        202: {
            "model": FitResource,
            "description": "Accepted; see Location. Or it has ended, but there is no time for the file that is wanted.",
            "headers": ACCEPTED_HEADERS | REPLAYED | RATE_LIMIT,
        },
        **problems(400, 406, 409, 413, 415, 422, 429, 503),
    },
)
async def create(
    request: Request, context: ContextDep, caller: CallerDep, query: Annotated[FitQuery, Query()]
) -> Response:
    """Take a point set, fit it in a worker, and answer with the fit.

    Waits up to `Prefer: wait=N` seconds (30 if not said); after that, or at once with `Prefer: respond-async`, the
    answer is 202 with the fit's Location. With an Accept header for a zero-set file, the file is the answer. Options
    stand in the JSON body or in the query; the query wins.
    """
    fits, limits = context.fits, context.limits
    kind = negotiation.point_set_format(request, query.format)
    await fits.check_room(caller, idempotency_key(request), small=body.is_small(request))
    stream = body.counted(request, context.transit, caller.client)
    async with body.received(request, kind, limits.body_bytes, context.incoming, stream) as content:
        wanted, accepted = await while_present(request, _accepted(request, context, caller, query, content))
    preferences = Preferences.of(request)
    seconds = preferences.seconds(DEFAULT_WAIT, limits.wait)
    with phase(request, "wait"):
        fit = await while_present(request, fits.awaited(caller, accepted.fit, seconds))
    left = rate_limit_fields(accepted.allowances)
    headers = {"Location": fit_path(request, fit.id), **left, **preferences.applied(seconds)}
    if accepted.replayed:
        headers["Idempotency-Replayed"] = "true"
    if not fit.status.final:
        return fit_response(request, fit, await fits.progress(fit), HTTPStatus.ACCEPTED, headers)
    if wanted is not None:
        mesh = MeshRequest(wanted.name)
        try:
            with phase(request, "mesh"):
                file = await while_present(request, context.files.zero_set(caller, fit, mesh))
        except (QueueFullError, NotReadyError, asyncio.CancelledError):  # the server is too busy for it, or stops
            return fit_response(request, fit, [], HTTPStatus.ACCEPTED, headers)
        return zero_set_response(request, fit, wanted, file, context.files.zero_set_name(fit, mesh), headers)
    return fit_response(request, fit, [], headers=headers)


async def _accepted(
    request: Request, context: Context, caller: Caller, query: FitQuery, content: bytes | Path
) -> tuple[ZeroSetFormat | None, Accepted]:
    """Read a point set and accept its fit, in turn with other clients.

    Return the format of zero sets that is wanted in the answer, if any, and the fit.
    """
    fits, limits = context.fits, context.limits
    kind, key = negotiation.point_set_format(request, query.format), idempotency_key(request)
    asked = ReadRequest(kind, query.columns, query.missing, caller.client)

    async def points_read() -> ReceivedPoints:
        with phase(request, "read"):
            return await fits.read(content, asked)

    large = await points_read() if isinstance(content, Path) else None  # which has a queue of its own
    async with context.turns.taken(caller.client):
        points = large or await points_read()
        options = requested(points.options, query.model_dump(exclude_unset=True, exclude=NO_OPTIONS))
        options = limits.capped(points.dimension, options)
        plan = fits.plan(points, options)
        limits.check_system(points, plan)
        wanted = negotiation.wanted_file(request, points.dimension)
        with phase(request, "store"):
            accepted = await fits.accept(points, options, plan, caller, key, callback=query.callback)
    return wanted, accepted


@router.get(
    "/{fit_id}",
    summary="Look at a fit",
    openapi_extra={"parameters": [PREFER, IF_NONE_MATCH]},
    responses={200: {"model": FitResource}, 304: {"description": "Unchanged."}, **problems(404, 422, 503)},
)
async def read(request: Request, context: ContextDep, caller: CallerDep, fit_id: FitId) -> Response:
    """Return a fit; with `Prefer: wait=N`, after at most N seconds if it is still live."""
    preferences = Preferences.of(request)
    seconds = preferences.seconds(0.0, context.limits.wait)
    with phase(request, "wait"):
        fit = await while_present(request, context.fits.get(caller, fit_id, seconds))
    return fit_response(request, fit, await context.fits.progress(fit), headers=preferences.applied(seconds))


@router.delete(
    "/{fit_id}",
    summary="Dismiss or remove a fit",
    openapi_extra={"parameters": [IF_MATCH]},
    responses={
        200: {"model": FitResource, "description": "It has ended: it was dismissed now, or had ended before."},
        204: {"description": "It is removed, with its points."},
        **problems(404, 412, 422, 503),
    },
)
async def dismiss(
    request: Request, context: ContextDep, caller: CallerDep, fit_id: FitId, *, purge: Purge = False
) -> Response:
    """Dismiss a fit if it is live, killing the process that works on it; with `purge=true`, remove it as well.

    Without `purge`, a fit that has ended stays as it is, so that the request may be sent again.
    """
    fits = context.fits
    fit = await fits.get(caller, fit_id)
    check_match(request, fit, await fits.progress(fit))
    was_live, fit = not fit.status.final, await fits.dismiss(caller, fit_id)
    if was_live and fit.status is not FitStatus.DISMISSED:  # it ended by itself in this moment, and is another now
        check_match(request, fit, [])
    if purge:
        await fits.purge(caller, fit_id)
        return Response(status_code=HTTPStatus.NO_CONTENT)
    return fit_response(request, fit, [])
