"""The command line application and its commands."""

import typer

from service.cli import fit, server, worker

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Implicit polynomials from point sets, of the degree they need.",
)
COMMANDS = (
    fit.fit,
    server.serve,
    worker.worker,
    server.key,
    server.openapi,
    server.settings,
    server.options,
    server.problems,
    server.healthcheck,
)
for command in COMMANDS:
    app.command()(command)
