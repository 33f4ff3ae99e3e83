"""A small web server beside the work of a process, for its supervisors."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager

import uvicorn

from service.api.probes import create_probes
from service.api.watch import Watch
from service.bootstrap.server import connection_limits
from service.connections.census import Census
from service.connections.protocol import guarded
from service.settings import Settings
from service.telemetry.connections import ConnectionCounts


class _Server(uvicorn.Server):
    """Uvicorn that leaves signals to the process that it runs in."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Do nothing."""
        yield


@asynccontextmanager
async def serving(settings: Settings, port: int, watch: Watch) -> AsyncIterator[None]:
    """Answer `/livez`, `/readyz` and `/metrics` at this port."""
    limits = connection_limits(settings)
    census = Census(limits)
    watch.exposition.add(ConnectionCounts(lambda: census.open, lambda: census.refusals))
    server = _Server(
        uvicorn.Config(
            create_probes(watch),
            host=settings.host,
            port=port,
            http=guarded(limits, census),
            ws="none",
            lifespan="off",
            server_header=False,
            timeout_graceful_shutdown=1,
            log_config=None,  # as the process has configured it
        )
    )
    running = asyncio.create_task(server.serve())
    try:
        yield
    finally:
        server.should_exit = True
        await asyncio.gather(running, return_exceptions=True)
