"""`ipfit serve`: the server."""

import os
import resource
import threading
from typing import Annotated

import typer

from service.cli.chosen import chosen_settings
from service.workers import fork_server

# Of each thread: the system's default of 8 MiB counts in full, and a server has three threads for each worker.
STACK_BYTES = 2 * 2**20


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on; else IPFIT_HOST.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; else IPFIT_PORT.")] = None,
) -> None:
    """Serve fits over HTTP, alone or as one of many around a database. Settings come from IPFIT_* variables."""
    given = {"host": host, "port": port}
    chosen = chosen_settings().model_copy(update={name: value for name, value in given.items() if value is not None})
    protect(chosen.server_memory)
    fork_server.start()
    from service.cli.web_server import run  # noqa: PLC0415 - loaded while the fork server loads what workers need

    run(chosen)


def protect(memory: int) -> None:
    """Limit the memory of this process, and let nobody but its user read the files that it makes.

    Its workers, which inherit both, set a limit of their own.
    """
    os.umask(0o077)
    threading.stack_size(STACK_BYTES)
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (memory if hard == resource.RLIM_INFINITY else min(memory, hard), hard))
