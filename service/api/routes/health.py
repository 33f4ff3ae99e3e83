"""The routes by which a supervisor of the server asks whether it is alive and ready."""

from fastapi import APIRouter

from service.api.dependencies import WatchDep
from service.api.descriptions import problem
from service.api.schemas import Health

router = APIRouter(tags=["health"])


@router.get("/livez", summary="Alive?")
async def livez() -> Health:
    """Answer whenever the process runs, whatever it depends on."""
    return Health(status="ok")


@router.get("/readyz", summary="Ready for work?", responses={503: problem("Not ready.")})
async def readyz(watch: WatchDep) -> Health:
    """Answer while fits can be looked up, the workers can fit, and the process is not about to stop, else 503.

    That the workers can fit is shown by a tiny fit every half minute. A disk that is full does not count: what was
    fitted can still be had. New fits are then answered with 503.
    """
    await watch.check_ready()
    return Health(status="ok")
