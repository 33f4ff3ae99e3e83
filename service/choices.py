"""A pydantic type for values that are one of a fixed list of words, written into the JSON schema where it is used."""

from collections.abc import Iterable
from enum import StrEnum
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

from pydantic import GetCoreSchemaHandler
from pydantic_core import core_schema


class OneOf:
    """Metadata of `Annotated[kind, OneOf(words)]`: accept these words only.

    `kind` is `str` or an enumeration of strings, whose members the words become. Unlike a bare enumeration it makes no
    schema of its own in the OpenAPI document, and unlike `Literal` it can take its words from a list that is kept
    elsewhere.

    >>> from pydantic import TypeAdapter
    >>> TypeAdapter(Annotated[str, OneOf(["up", "down"])]).json_schema()
    {'enum': ['up', 'down'], 'type': 'string'}
    """

    def __init__(self, words: Iterable[str]) -> None:
        """Take the words, in the order in which the schema lists them."""
        self._words = [str(word) for word in words]

    def __get_pydantic_core_schema__(self, kind: type[str], _handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Return the schema by which pydantic validates, serialises and documents the type."""
        return core_schema.no_info_after_validator_function(
            kind,
            core_schema.literal_schema(self._words),
            serialization=core_schema.plain_serializer_function_ser_schema(str),
        )


def alternatives(annotation: object) -> list[type]:
    """Return the types that a field's annotation allows, without None and without metadata.

    >>> alternatives(Annotated[str, OneOf(["up"])] | None), alternatives(int)
    ([<class 'str'>], [<class 'int'>])
    """
    if get_origin(annotation) is Annotated:
        return alternatives(get_args(annotation)[0])
    parts: tuple[Any, ...] = get_args(annotation)
    return [kind for part in parts for kind in alternatives(part)] if parts else _without_none(annotation)


def _without_none(annotation: Any) -> list[type]:  # noqa: ANN401 - whatever stands in an annotation
    return [] if annotation is NoneType else [annotation]


def words(annotation: object) -> list[str]:
    """Return the words that a field's annotation allows, if it allows members of an enumeration.

    >>> from ipcore import Ridge
    >>> words(Annotated[Ridge, OneOf(Ridge)])
    ['none', 'full', 'selective']
    """
    kinds = [kind for kind in alternatives(annotation) if issubclass(kind, StrEnum)]
    return [str(member) for kind in kinds for member in kind]
