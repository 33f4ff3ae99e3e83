"""The web application, for the store that the settings name."""

import asyncio
from contextlib import AbstractAsyncContextManager

from fastapi import FastAPI

from service.api.app import create_app
from service.api.dependencies import Context
from service.jobs.use_cases import FitService
from service.settings import Settings


def application(settings: Settings) -> FastAPI:
    """Return the application: a replica of a cluster if a shared database is set, else an embedded server."""
    origins = [origin.strip() for origin in settings.cors_origins.split(",") if origin.strip()]
    return create_app(lambda: _context(settings), origins)


def _context(settings: Settings) -> AbstractAsyncContextManager[Context]:
    """Return the context of the routes. The libraries of a cluster are loaded where there is one."""
    if settings.database_url is None:
        from service.bootstrap.embedded import context  # noqa: PLC0415 - see above
    else:
        from service.bootstrap.replica import context  # noqa: PLC0415 - see above
    return context(settings)


async def drain(app: FastAPI, seconds: float) -> None:
    """Let a running application accept no more fits, and give those that run so much time to end."""
    await _fits(app).drain(seconds)


def end_drain(app: FastAPI) -> None:
    """End a drain at once; may be called from a signal handler."""
    if hasattr(app.state, "context"):  # else it is still starting, and runs nothing
        asyncio.get_running_loop().call_soon_threadsafe(_fits(app).end_drain)


def _fits(app: FastAPI) -> FitService:
    fits: FitService = app.state.context.fits
    return fits
