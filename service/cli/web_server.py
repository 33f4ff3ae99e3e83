"""Commands about the server: run it, print its OpenAPI document, settings and options, check that it is ready."""

import os
import resource
import signal
import socket
import sys
import threading
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

from service.api_keys import ApiKeysError, new_key
from service.bootstrap import application, connection_limits, drain, end_drain
from service.cli.option_texts import table as fit_options
from service.connections.protocol import guarded
from service.problem_types import table as problem_table
from service.settings import Settings, table
from service.telemetry.logs import log_config

# Seconds that running requests get to end when the server stops: uploads and exports of zero sets. Requests that wait
# for a fit are answered at once.
GRACE_SECONDS = 5
# The same after a second signal.
SHORT_GRACE_SECONDS = 1
# Of each thread: the system's default of 8 MiB counts in full, and a server has three threads for each worker.
STACK_BYTES = 2 * 2**20


class _Server(uvicorn.Server):
    """Uvicorn that drains the application on the first signal, while it goes on answering, and ends on the second."""

    def __init__(self, app: FastAPI, settings: Settings) -> None:
        super().__init__(
            uvicorn.Config(
                app,
                host=settings.host,
                port=settings.port,
                http=guarded(connection_limits(settings)),
                root_path=settings.root_path,
                ws="none",
                server_header=False,
                log_config=log_config(),
                forwarded_allow_ips=settings.forwarded_allow_ips,
                timeout_graceful_shutdown=GRACE_SECONDS,
            )
        )
        self._app, self._grace, self._drained = app, settings.shutdown_grace, False

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


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on; else IPFIT_HOST.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; else IPFIT_PORT.")] = None,
) -> None:
    """Serve fits over HTTP, alone or as one of many around a database. Settings come from IPFIT_* variables."""
    given = {"host": host, "port": port}
    chosen = chosen_settings().model_copy(update={name: value for name, value in given.items() if value is not None})
    # Uvicorn raises the signals that it received again when it has stopped; the exit code is to be 0 all the same.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    protect(chosen.server_memory)
    with suppress(KeyboardInterrupt):
        _Server(application(chosen), chosen).run()


def protect(memory: int) -> None:
    """Limit the memory of this process, and let nobody but its user read the files that it makes.

    Its workers, which inherit both, set a limit of their own.
    """
    os.umask(0o077)
    threading.stack_size(STACK_BYTES)
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (memory if hard == resource.RLIM_INFINITY else min(memory, hard), hard))


def key(name: Annotated[str, typer.Argument(help="The caller: letters, digits, dots, hyphens, underscores.")]) -> None:
    """Make an API key: print it once, and the entry for the file that IPFIT_API_KEYS names."""
    try:
        made, entry = new_key(name)
    except ApiKeysError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from error
    typer.echo(f"# the key, for the caller; it is stored nowhere: {made}")
    typer.echo(entry, nl=False)


def openapi() -> None:
    """Print the OpenAPI document."""
    document = application(chosen_settings()).openapi()
    sys.stdout.buffer.write(orjson.dumps(document, option=orjson.OPT_INDENT_2) + b"\n")


def settings() -> None:
    """Print every setting as a Markdown table: environment variable, default, meaning."""
    typer.echo(table())


def problems() -> None:
    """Print every type of problem as a Markdown table: name, status, meaning and what helps."""
    typer.echo(problem_table())


def options() -> None:
    """Print every option of a fit as a Markdown table: name, values, default, meaning."""
    typer.echo(fit_options())


def healthcheck() -> None:
    """Exit with 0 if the server on this machine is ready, else with 1."""
    given = chosen_settings()
    host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(given.host, given.host)  # noqa: S104 - compared, not bound
    try:
        with urlopen(f"http://{host}:{given.port}/readyz", timeout=5.0):
            return
    except (URLError, OSError) as error:
        typer.echo(f"not ready: {error}", err=True)
        raise typer.Exit(1) from error


def chosen_settings() -> Settings:
    """Return the settings, or print which variable is wrong and exit."""
    try:
        return Settings()
    except ValidationError as error:
        for one in error.errors():
            typer.echo(f"IPFIT_{str(one['loc'][0]).upper()}: {one['msg']}", err=True)
        raise typer.Exit(2) from error
