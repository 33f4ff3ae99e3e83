"""The command line application and its commands, of which only the one that is called is loaded."""

from importlib import import_module
from typing import Any

import typer
from typer.core import TyperGroup

# In the order of `ipfit --help`. `serve` and `fit` load most of the program; the others should answer at once, the
# health check above all, which containers call again and again.
MODULES = {
    "fit": "service.cli.fit",
    "verify": "service.cli.verify",
    "serve": "service.cli.serve",
    "worker": "service.cli.worker",
    "key": "service.cli.key",
    "openapi": "service.cli.documents",
    "settings": "service.cli.documents",
    "options": "service.cli.documents",
    "problems": "service.cli.documents",
    "healthcheck": "service.cli.healthcheck",
}


class Commands(TyperGroup):
    """The commands of `MODULES`, each loaded when it is asked for."""

    def list_commands(self, _: Any) -> list[str]:  # noqa: ANN401 - typer does not export its context
        """Return the names of all commands."""
        return list(MODULES)

    def get_command(self, _: Any, name: str) -> Any:  # noqa: ANN401 - as above, nor its commands
        """Return a command, or None if there is none of this name."""
        if name not in MODULES:
            return None
        one = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
        one.command(name)(getattr(import_module(MODULES[name]), name))
        return typer.main.get_command(one)


app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)


@app.callback(cls=Commands)
def ipfit() -> None:
    """Implicit polynomials from point sets, of the degree they need."""
