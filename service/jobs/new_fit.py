"""Making a fit from what a request asks for."""

import hashlib
from datetime import UTC, datetime
from uuid import uuid4

import orjson

import ipcore
from service.jobs.callback import Callback
from service.jobs.caller import Caller
from service.jobs.fit import Fit, FitStatus, PointSetRef, ReceivedPoints
from service.jobs.requested_options import RequestedOptions


def new_fit(  # noqa: PLR0913 - what is fitted, how, for whom
    points: ReceivedPoints,
    requested: RequestedOptions,
    plan: ipcore.Plan,
    *,
    caller: Caller,
    key: str | None,
    callback: str | None = None,
) -> Fit:
    """Return a new, accepted fit.

    Its payload is the same for the same points, dimension, given options and URL of the callback.
    """
    told = [] if callback is None else [callback]  # as in versions without callbacks
    payload = orjson.dumps([points.key, points.dimension, requested.given, *told], option=orjson.OPT_SORT_KEYS)
    return Fit(
        id=uuid4().hex,
        status=FitStatus.ACCEPTED,
        input=PointSetRef(points.key, points.dimension, points.points, len(points.content), points.summary),
        requested=requested,
        created=datetime.now(UTC),
        client=caller.client,
        owner=caller.owner,
        cost=plan.seconds,
        key=key,
        payload=hashlib.sha256(payload).hexdigest(),
        callback=None if callback is None else Callback(callback),
    )
