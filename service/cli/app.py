"""The commands, gathered."""

import typer

from service.cli import fit, server

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Implicit polynomials from point sets, of the degree they need.",
)
for command in (fit.fit, server.serve, server.openapi, server.settings, server.options, server.healthcheck):
    app.command()(command)
