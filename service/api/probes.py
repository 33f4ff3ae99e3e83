"""The web application of a process that answers supervisors only: alive, ready, metrics."""

from fastapi import FastAPI

from service.api import problems
from service.api.openapi import DocumentedApp
from service.api.routes import health, metrics
from service.api.watch import Watch


def create_probes(watch: Watch) -> FastAPI:
    """Return the application, whose routes `watch` answers."""
    app = DocumentedApp(openapi_url=None, docs_url=None, redoc_url=None, redirect_slashes=False)
    app.state.watch = watch
    problems.install(app)
    for router in (health.router, metrics.router):
        app.include_router(router)
    return app
