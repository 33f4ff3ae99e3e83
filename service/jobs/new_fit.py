"""Making a fit from what a request asks for."""

import hashlib
from datetime import UTC, datetime
from uuid import uuid4

import orjson

import ipcore
from service.jobs.caller import Caller
from service.jobs.fit import Fit, FitStatus, PointSetRef, ReceivedPoints
from service.jobs.requested_options import RequestedOptions


def new_fit(
    points: ReceivedPoints, requested: RequestedOptions, plan: ipcore.Plan, caller: Caller, key: str | None
) -> Fit:
    """Return a new, accepted fit. Its payload is the same for the same points, dimension and given options."""
    payload = orjson.dumps([points.key, points.dimension, requested.given], option=orjson.OPT_SORT_KEYS)
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
    )
