"""The settings that the environment holds, for commands."""

import typer
from pydantic import ValidationError

from service.settings import Settings


def chosen_settings() -> Settings:
    """Return the settings, or print which variable is wrong and exit."""
    try:
        return Settings()
    except ValidationError as error:
        for one in error.errors():
            typer.echo(f"IPFIT_{str(one['loc'][0]).upper()}: {one['msg']}", err=True)
        raise typer.Exit(2) from error
