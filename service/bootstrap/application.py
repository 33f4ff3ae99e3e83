"""The web application, on the store that the settings name."""

import asyncio

from fastapi import FastAPI

from service.api.app import create_app
from service.bootstrap import cluster, embedded
from service.jobs.use_cases import FitService
from service.settings import Settings


def application(settings: Settings) -> FastAPI:
    """Return the application: a replica of a cluster if there is a shared database, else a server of its own."""
    room = embedded if settings.database_url is None else cluster
    return create_app(lambda: room.context(settings))


async def drain(app: FastAPI, seconds: float) -> None:
    """Have a running application accept nothing more, and let what runs end in so much time."""
    await _fits(app).drain(seconds)


def hurry(app: FastAPI) -> None:
    """End a drain at once; may be called from a signal handler."""
    if hasattr(app.state, "context"):  # else it is still starting, and runs nothing
        asyncio.get_running_loop().call_soon_threadsafe(_fits(app).hurry)


def _fits(app: FastAPI) -> FitService:
    fits: FitService = app.state.context.fits
    return fits
