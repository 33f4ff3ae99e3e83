"""`ipfit worker`: run the fits of servers that share a database."""

import asyncio

import typer

from service.workers import fork_server


def worker() -> None:
    """Run the fits that servers put in the database at IPFIT_DATABASE_URL; on SIGTERM, end what runs and leave."""
    fork_server.start()
    # loaded while the fork server loads what workers need
    from service.bootstrap.worker import work  # noqa: PLC0415 - see above
    from service.cli.chosen import chosen_settings  # noqa: PLC0415 - see above
    from service.telemetry.logs import configure  # noqa: PLC0415 - see above

    settings = chosen_settings()
    if settings.database_url is None:
        typer.echo("IPFIT_DATABASE_URL is not set: workers need the database of the servers", err=True)
        raise typer.Exit(2)
    configure(settings.log_format, settings.log_level)
    asyncio.run(work(settings))
