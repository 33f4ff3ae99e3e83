"""`ipfit worker`: run the fits of servers that share a database."""

import asyncio

import typer

from service.cli.chosen import chosen_settings
from service.telemetry.logs import configure
from service.workers import fork_server


def worker() -> None:
    """Run the fits that servers put in the database at IPFIT_DATABASE_URL; on SIGTERM, end what runs and leave."""
    settings = chosen_settings()
    if settings.database_url is None:
        typer.echo("IPFIT_DATABASE_URL is not set: workers need the database of the servers", err=True)
        raise typer.Exit(2)
    configure(settings.log_format, settings.log_level)
    fork_server.start()
    from service.bootstrap.worker import work  # noqa: PLC0415 - loaded while the fork server loads what workers need

    asyncio.run(work(settings))
