"""Uvicorn around the application, from its start to an orderly end."""

import gc
import signal
import socket
import sys
from contextlib import suppress
from types import FrameType

import uvicorn
from fastapi import FastAPI

from service.bootstrap.application import application, drain, end_drain
from service.bootstrap.server import connection_limits
from service.connections.census import Census
from service.connections.protocol import guarded
from service.settings import Settings
from service.telemetry.connections import ConnectionCounts
from service.telemetry.logs import log_config

# Seconds that running requests get to end when the server stops: uploads and exports of zero sets. Requests that wait
# for a fit are answered at once.
GRACE_SECONDS = 5
# The same after a second signal.
SHORT_GRACE_SECONDS = 1


class _Server(uvicorn.Server):
    """Uvicorn that drains the application on the first signal, while it goes on answering, and ends on the second."""

    def __init__(self, app: FastAPI, settings: Settings) -> None:
        limits = connection_limits(settings)
        self._census = Census(limits)
        super().__init__(
            uvicorn.Config(
                app,
                host=settings.host,
                port=settings.port,
                http=guarded(limits, self._census),
                root_path=settings.root_path,
                ws="none",
                server_header=False,
                log_config=log_config(settings.log_format, settings.log_level),
                forwarded_allow_ips=settings.forwarded_allow_ips,
                timeout_graceful_shutdown=GRACE_SECONDS,
            )
        )
        self._app, self._grace, self._drained = app, settings.shutdown_grace, False

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if hasattr(self._app.state, "watch"):  # else it could not start
            counts = ConnectionCounts(lambda: self._census.open, lambda: self._census.refusals)
            self._app.state.watch.exposition.add(counts)
        gc.collect()
        gc.freeze()  # a later collection would look through all that was loaded, and stop all answers for 70 ms

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        if self.should_exit:
            end_drain(self._app)
            self.config.timeout_graceful_shutdown = SHORT_GRACE_SECONDS
            self.force_exit = self._drained  # uvicorn then waits no longer; running fits were released
        super().handle_exit(sig, frame)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        await drain(self._app, self._grace)
        self._drained = True
        await super().shutdown(sockets)


def run(settings: Settings) -> None:
    """Serve until a signal ends it; the exit code is then 0."""
    # Uvicorn raises the signals that it received again when it has stopped.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with suppress(KeyboardInterrupt):
        _Server(application(settings), settings).run()
