"""The web application; `service.bootstrap` makes the parts that it uses."""

from collections.abc import AsyncIterator, Callable, MutableMapping, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from importlib.metadata import version
from typing import Any

from fastapi import Depends, FastAPI
from fastapi.middleware.cors import CORSMiddleware
from fastapi.telemetry import TelemetryConfig

from service.api import docs, problems
from service.api.callers import caller_of
from service.api.dependencies import Context
from service.api.known_parameters import refuse_unknown_parameters
from service.api.methods import HeadAndOptions
from service.api.openapi import DocumentedApp
from service.api.routes import ROUTERS, metrics

DESCRIPTION = """\
Turns 2D and 3D point sets into implicit polynomials f(x) = 0 whose degree finds itself.

**f(x) = Σ coefficientᵢ · ((x − centre)/scale)^exponentᵢ, negative inside.**

Lengths in options and diagnostics are in *mean radii*: the mean distance of the points from their centroid. Coordinates
are always the caller's. Errors are problem details (RFC 9457).
"""

# The headers that pages of other origins may send and read, where those are allowed.
CORS_SENT = [
    "Authorization",
    "Content-Type",
    "Idempotency-Key",
    "If-Match",
    "If-None-Match",
    "If-Range",
    "Prefer",
    "Range",
    "Traceparent",
    "X-Request-Id",
]
CORS_READ = [
    "Accept-Ranges",
    "Content-Disposition",
    "Content-Location",
    "Content-Range",
    "ETag",
    "Idempotency-Replayed",
    "Link",
    "Location",
    "Preference-Applied",
    "RateLimit",
    "RateLimit-Policy",
    "Retry-After",
    "Server-Timing",
    "Traceparent",
    "X-Request-Id",
    "Zero-Set-Warning",
]

# The last parts of the paths of what supervisors ask every few seconds: requests that nobody wants to trace.
SUPERVISED = {"livez", "readyz", "metrics"}


def _is_supervision(scope: MutableMapping[str, Any]) -> bool:
    return str(scope.get("path", "")).rpartition("/")[2] in SUPERVISED


# With the extra `otel`, if OTEL_EXPORTER_OTLP_ENDPOINT says where to. Only traces: the log, which may name addresses
# and paths, is for this machine, and metrics are at /metrics.
TRACES: TelemetryConfig = {
    "auto_configure": True,
    "metrics": False,
    "logs": False,
    "operation_spans": False,
    "exclude": _is_supervision,
}

Startup = Callable[[], AbstractAsyncContextManager[Context]]


def create_app(startup: Startup, cors_origins: Sequence[str] = ()) -> FastAPI:
    """Return the application.

    Parameters
    ----------
    startup
        Opens the parts that its routes use, and closes them when it ends.
    cors_origins
        Origins whose pages may call this server in a browser; `*` means all.

    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with startup() as context:
            app.state.context, app.state.watch = context, context.watch
            yield

    app = DocumentedApp(
        title="ipfit",
        version=version("ipfit"),
        summary="Implicit polynomials from point sets, of the degree they need.",
        description=DESCRIPTION,
        license_info={"name": "MIT", "identifier": "MIT"},
        openapi_url=None,  # `service.api.docs` has the document and the page
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,  # a path with a slash more is another one; a redirect would make a client send twice
        dependencies=[Depends(refuse_unknown_parameters)],
        lifespan=lifespan,
        generate_unique_id_function=lambda route: route.name,
        telemetry=TRACES,
    )
    app.add_middleware(HeadAndOptions)
    if cors_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=cors_origins,
            allow_methods=["GET", "HEAD", "POST", "DELETE"],
            allow_headers=CORS_SENT,
            expose_headers=CORS_READ,
        )
    problems.install(app)
    for router in ROUTERS:
        app.include_router(router)
    app.include_router(metrics.router, dependencies=[Depends(caller_of)])
    docs.install(app)
    return app
