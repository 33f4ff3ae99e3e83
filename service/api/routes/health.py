"""Whether the server lives, and whether it is ready."""

from fastapi import APIRouter

from service.api.dependencies import Here
from service.api.openapi import problem
from service.api.schemas import Health

router = APIRouter(tags=["health"])


@router.get("/livez", summary="Alive?")
async def livez() -> Health:
    """Answer whenever the process runs, whatever it depends on."""
    return Health(status="ok")


@router.get("/readyz", summary="Ready for work?", responses={503: problem("Not ready.")})
async def readyz(here: Here) -> Health:
    """Answer while fits can be looked up and the server is not about to stop, else 503.

    A disk that is full does not count: what was fitted can still be had. New fits are then answered with 503.
    """
    await here.desk.check()
    return Health(status="ok")
