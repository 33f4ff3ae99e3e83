"""`ipfit healthcheck`: ask the server on this machine whether it is ready."""

from urllib.error import URLError
from urllib.request import urlopen

import typer

from service.cli.chosen import chosen_settings


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
