"""Commands about the server: run it, print its OpenAPI document, ask whether it is ready."""

import signal
import socket
import sys
from contextlib import suppress
from types import FrameType
from typing import Annotated
from urllib.error import URLError
from urllib.request import urlopen

import orjson
import typer
import uvicorn
from fastapi import FastAPI
from pydantic import ValidationError

from service.bootstrap import application, drain, end_drain
from service.options import table as fit_options
from service.settings import Settings, table

# Seconds that requests get to end when the server stops. Whoever waits for a fit is answered at once; this is for
# uploads and drawings.
GRACE = 5
# … and after a second signal.
SHORT_GRACE_SECONDS = 1


class _Server(uvicorn.Server):
    """Uvicorn, which on the first signal drains the application while it goes on answering, and on the second ends."""

    def __init__(self, app: FastAPI, settings: Settings) -> None:
        super().__init__(uvicorn.Config(app, host=settings.host, port=settings.port, timeout_graceful_shutdown=GRACE))
        self._app, self._grace, self._drained = app, settings.shutdown_grace, False

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        if self.should_exit:
            end_drain(self._app)
            self.config.timeout_graceful_shutdown = SHORT_GRACE_SECONDS
            self.force_exit = self._drained  # uvicorn's own word for waiting no longer; what ran was given back
        super().handle_exit(sig, frame)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        await drain(self._app, self._grace)
        self._drained = True
        await super().shutdown(sockets)


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on; else IPFIT_HOST.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; else IPFIT_PORT.")] = None,
) -> None:
    """Serve fits over HTTP, alone or as one of many around a database. Settings come from IPFIT_* variables."""
    given = {"host": host, "port": port}
    chosen = chosen_settings().model_copy(update={name: value for name, value in given.items() if value is not None})
    # Uvicorn takes signals while it runs and raises them again when it has stopped: to stop when told to is no failure.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with suppress(KeyboardInterrupt):
        _Server(application(chosen), chosen).run()


def openapi() -> None:
    """Print the OpenAPI document."""
    document = application(chosen_settings()).openapi()
    sys.stdout.buffer.write(orjson.dumps(document, option=orjson.OPT_INDENT_2) + b"\n")


def settings() -> None:
    """Print every setting as a Markdown table: environment variable, default, meaning."""
    typer.echo(table())


def options() -> None:
    """Print every option of a fit as a Markdown table: name, values, default, meaning."""
    typer.echo(fit_options())


def healthcheck() -> None:
    """Exit with 0 if the server on this machine is ready, else with 1."""
    given = chosen_settings()
    host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(given.host, given.host)  # noqa: S104 - looked up, not bound
    try:
        with urlopen(f"http://{host}:{given.port}/readyz", timeout=5.0):
            return
    except (URLError, OSError) as error:
        typer.echo(f"not ready: {error}", err=True)
        raise typer.Exit(1) from error


def chosen_settings() -> Settings:
    """Return the settings, or say which variable is wrong."""
    try:
        return Settings()
    except ValidationError as error:
        for one in error.errors():
            typer.echo(f"IPFIT_{str(one['loc'][0]).upper()}: {one['msg']}", err=True)
        raise typer.Exit(2) from error
