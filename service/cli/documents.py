"""Commands that print what the program says of itself; `make openapi docs` writes it to files."""

import sys

import orjson
import typer

from service.bootstrap.application import application
from service.cli.chosen import chosen_settings
from service.cli.option_texts import table as fit_options
from service.problem_types import table as problem_table
from service.settings import table


def openapi() -> None:
    """Print the OpenAPI document."""
    document = application(chosen_settings()).openapi()
    sys.stdout.buffer.write(orjson.dumps(document, option=orjson.OPT_INDENT_2) + b"\n")


def settings() -> None:
    """Print every setting as a Markdown table: environment variable, default, meaning."""
    typer.echo(table())


def options() -> None:
    """Print every option of a fit as a Markdown table: name, values, default, meaning."""
    typer.echo(fit_options())


def problems() -> None:
    """Print every type of problem as a Markdown table: name, status, meaning and what helps."""
    typer.echo(problem_table())
