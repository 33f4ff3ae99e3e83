"""The web application; `service.bootstrap` makes the parts that it uses."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from importlib.metadata import version

from fastapi import FastAPI

from service.api import docs, problems
from service.api.dependencies import Context
from service.api.head import HeadAsGet
from service.api.openapi import DocumentedApp
from service.api.routes import ROUTERS

DESCRIPTION = """\
Turns 2D and 3D point sets into implicit polynomials f(x) = 0 whose degree finds itself.

**f(x) = Σ coefficientᵢ · ((x − centre)/scale)^exponentᵢ, negative inside.**

Lengths in options and diagnostics are in *mean radii*: the mean distance of the points from their centroid. Coordinates
are always the caller's. Errors are problem details (RFC 9457).
"""

Startup = Callable[[], AbstractAsyncContextManager[Context]]


def create_app(startup: Startup) -> FastAPI:
    """Return the application; `startup` opens the parts that its routes use, and closes them when it ends."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with startup() as context:
            app.state.context = context
            yield

    app = DocumentedApp(
        title="ipfit",
        version=version("ipfit"),
        summary="Implicit polynomials from point sets, of the degree they need.",
        description=DESCRIPTION,
        license_info={"name": "MIT", "identifier": "MIT"},
        docs_url=None,
        redoc_url=None,
        lifespan=lifespan,
        generate_unique_id_function=lambda route: route.name,
    )
    app.add_middleware(HeadAsGet)
    problems.install(app)
    for router in ROUTERS:
        app.include_router(router)
    docs.install(app)
    return app
