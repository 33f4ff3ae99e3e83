"""The metrics of this process, for Prometheus."""

from fastapi import APIRouter, Request, Response

from service.api import negotiation
from service.api.dependencies import WatchDep

router = APIRouter(tags=["health"])
# Prometheus asks for both, and prefers the second.
TEXT, OPEN_METRICS = "text/plain", "application/openmetrics-text"
EXPOSITION = r"^(#|[a-z_]+(\{| ))"  # how the text begins
_VERSIONS = {TEXT: "0.0.4", OPEN_METRICS: "1.0.0"}


@router.get(
    "/metrics",
    summary="Metrics",
    response_class=Response,
    responses={
        200: {
            "content": {
                kind: {"schema": {"type": "string", "maxLength": 2**20, "pattern": EXPOSITION}} for kind in _VERSIONS
            }
        }
    },
)
async def metrics(request: Request, watch: WatchDep) -> Response:
    """Return what this process counted since it started, and its queue, workers and memory now, for Prometheus."""
    accept = request.headers.get("accept", "*/*")
    kind = max(_VERSIONS, key=lambda one: negotiation.quality(accept, one))
    text = await watch.exposition.text(open_metrics=kind == OPEN_METRICS)
    return Response(text, media_type=f"{kind}; version={_VERSIONS[kind]}; charset=utf-8", headers={"Vary": "Accept"})
