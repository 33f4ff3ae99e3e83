"""Texts about the options of a fit, for the command line and docs/options.md."""

from pydantic.fields import FieldInfo

from service.choices import alternatives, words
from service.options import FitOptions

# How docs/options.md and the command line describe a default that depends on something else.
DEPENDENT_DEFAULTS = {
    "max_degree": "by dimension",
    "collinear": "by `ridge`",
    "signs": "see `geometric`",
    "geometric": "on",
}


def default(name: str) -> str:
    """Return the default of an option as Markdown text."""
    value = FitOptions.model_fields[name].default
    return DEPENDENT_DEFAULTS[name] if value is None else f"`{str(value).lower()}`"


def values(field: FieldInfo) -> str:
    """Return the values that an option allows as Markdown text: its words, or its range."""
    if named := words(field.annotation):
        return " ".join(f"`{word}`" for word in named)
    if bool in alternatives(field.annotation):
        return "`true` `false`"
    signs = {"ge": "≥", "gt": ">", "le": "≤", "lt": "<"}
    return ", ".join(
        f"{signs[name]} {getattr(bound, name):g}" for bound in field.metadata for name in signs if hasattr(bound, name)
    )


def table() -> str:
    """Return all options as a Markdown table with the columns name, values, default and meaning."""
    rows = ["| option | values | default | meaning |", "| --- | --- | --- | --- |"]
    for name, field in FitOptions.model_fields.items():
        rows.append(f"| `{name}` | {values(field)} | {default(name)} | {field.description} |")
    return "\n".join(rows)
