"""The fit options as options of a command: one for each field of the API's `FitOptions`, so that they cannot differ."""

import inspect
from collections.abc import Callable
from enum import Enum
from functools import wraps
from typing import Annotated, Any, Literal, get_args, get_origin

import typer
from pydantic.fields import FieldInfo

from service.options import FitOptions, default


def with_fit_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command an option for every fit option; it gets those that were given in its last parameter, `options`."""
    signature = inspect.signature(command)
    own = [parameter for name, parameter in signature.parameters.items() if name != "options"]
    more = [_parameter(name, field) for name, field in FitOptions.model_fields.items()]

    @wraps(command)
    def accepting(**given: object) -> None:
        chosen = {name: given.pop(name) for name in FitOptions.model_fields}
        options = {name: _plain(value) for name, value in chosen.items() if value is not None}
        command(**given, options=options)

    accepting.__signature__ = signature.replace(parameters=[*own, *more])  # type: ignore[attr-defined] # what typer reads
    accepting.__annotations__ = {parameter.name: parameter.annotation for parameter in [*own, *more]}
    return accepting


def _parameter(name: str, field: FieldInfo) -> inspect.Parameter:
    """Return the parameter of an option. Its default is None, for not given, as a preset may have its own."""
    shown = default(name).replace("`", "")
    option = typer.Option(help=field.description, show_default=shown, rich_help_panel="How to fit")
    kind: Any = _type(field) | None
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[kind, option])


def _type(field: FieldInfo) -> Any:  # noqa: ANN401 - a type, of a kind that annotations have no name for
    """Return the option's type without None."""
    kinds = [kind for kind in get_args(field.annotation) if kind is not type(None)]
    return field.annotation if get_origin(field.annotation) is Literal or len(kinds) != 1 else kinds[0]


def _plain(value: object) -> object:
    return value.value if isinstance(value, Enum) else value
