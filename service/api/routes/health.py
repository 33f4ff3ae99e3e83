"""Whether the server lives, and whether it is ready."""

from fastapi import APIRouter

from service.api.context import Here
from service.api.document import problem
from service.api.schemas import Health

router = APIRouter(tags=["health"])


@router.get("/livez", summary="Alive?")
async def livez() -> Health:
    """Answer whenever the process runs, whatever it depends on."""
    return Health(status="ok")


@router.get("/readyz", summary="Ready for work?", responses={503: problem("Not ready.")})
async def readyz(here: Here) -> Health:
    """Answer when fits can be stored and run; 503 while not."""
    await here.desk.check()
    return Health(status="ok")
