"""The options of a fit as options of a command, made from the fields of `service.options.FitOptions`."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any, cast

import typer
from pydantic.fields import FieldInfo

from service.choices import alternatives
from service.cli.option_texts import default
from service.jobs.errors import InvalidInputError
from service.options import FitOptions, agreeing


def with_fit_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command an option for every option of a fit; its last parameter, `options`, gets `ipcore.FitOptions`."""
    signature = inspect.signature(command)
    own = [parameter for name, parameter in signature.parameters.items() if name != "options"]
    more = [_parameter(name, field) for name, field in FitOptions.model_fields.items()]

    @wraps(command)
    def accepting(**given: object) -> None:
        chosen = {name: given.pop(name) for name in FitOptions.model_fields}
        given_options = {name: value for name, value in chosen.items() if value is not None}
        try:
            options = agreeing(given_options).complete
        except InvalidInputError as error:
            typer.echo(f"error: {error}", err=True)
            raise typer.Exit(2) from error
        command(**given, options=options)

    accepting.__signature__ = signature.replace(parameters=[*own, *more])  # type: ignore[attr-defined] # typer reads it
    accepting.__annotations__ = {parameter.name: parameter.annotation for parameter in [*own, *more]}
    return accepting


def _parameter(name: str, field: FieldInfo) -> inspect.Parameter:
    """Return the parameter of an option. Its default is None, for not given: a preset may have its own default."""
    shown = default(name).replace("`", "")
    option = typer.Option(help=field.description, show_default=shown, rich_help_panel="How to fit")
    (kind,) = alternatives(field.annotation)
    annotation: Any = Annotated[cast("Any", kind) | None, option]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)
