"""`ipfit key`: make an API key."""

from typing import Annotated

import typer

from service.api_keys import ApiKeysError, new_key


def key(name: Annotated[str, typer.Argument(help="The caller: letters, digits, dots, hyphens, underscores.")]) -> None:
    """Make an API key: print it once, and the entry for the file that IPFIT_API_KEYS names."""
    try:
        made, entry = new_key(name)
    except ApiKeysError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from error
    typer.echo(f"# the key, for the caller; it is stored nowhere: {made}")
    typer.echo(entry, nl=False)
