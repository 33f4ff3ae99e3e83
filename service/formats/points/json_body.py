"""Point sets as JSON: an object with `points`, and optionally `normals` and `options`."""

import base64
from itertools import chain
from typing import Any

import numpy as np
import orjson

from service.formats.points.npy import shaped
from service.formats.points.reading import (
    Array,
    RawPoints,
    ReadOptions,
    check_count,
    check_no_columns,
    doubles,
    number_type,
    shortened,
)
from service.jobs.errors import InvalidInputError, MalformedInputError

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"


def read_json(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the points of a JSON document.

    Raises
    ------
    MalformedInputError
        If the bytes are not JSON.
    InvalidInputError
        If a member is unknown, missing, or not what it must be.

    """
    check_no_columns(options, "JSON")
    try:
        document = orjson.loads(content.removeprefix(_BYTE_ORDER_MARK))
    except orjson.JSONDecodeError as error:
        raise MalformedInputError(f"not JSON: {error}") from error
    if not isinstance(document, dict):
        raise InvalidInputError("the body must be a JSON object with points, and optionally normals and options")
    unknown = min(document.keys() - {"points", "normals", "options"}, default=None)
    if unknown is not None:
        name = shortened(unknown)
        raise InvalidInputError(f"unknown member {name!r}; known are points, normals and options", (name,))
    if "points" not in document:
        raise InvalidInputError("points are missing", ("points",))
    fit_options = document.get("options", {})
    if not isinstance(fit_options, dict):
        raise InvalidInputError("options must be an object", ("options",))
    points, normals = document["points"], document.get("normals")
    return RawPoints(
        _array(points, "points", options),
        None if normals is None else _array(normals, "normals", options),
        fit_options,
    )


def _array(value: object, name: str, options: ReadOptions) -> Array:
    """Return the numbers (N, columns) of nested lists, or of {dtype, shape, data}."""
    if isinstance(value, dict):
        return _packed(value, name, options.max_points)
    if not isinstance(value, list):
        raise InvalidInputError(f"{name} must be a list of rows, or an object with dtype, shape and data", (name,))
    check_count(len(value), options.max_points, name)
    if not value:
        raise InvalidInputError(f"{name} are empty", (name,))
    width = len(value[0]) if isinstance(value[0], list) else None
    for i, row in enumerate(value):
        if not isinstance(row, list) or len(row) != width:
            raise InvalidInputError(f"{name} row {i} must be a list of as many numbers as row 0", (name, i))
    allowed = {int, float} if options.missing == "refuse" else {int, float, type(None)}
    # Checked before numpy sees them: of one long string it would make an array in which every item is as long.
    if not set(map(type, chain.from_iterable(value))) <= allowed:
        raise _not_a_number(value, name, allowed)
    return np.array(value, dtype=np.float64)  # null becomes nan


def _not_a_number(rows: list[list[Any]], name: str, allowed: set[type]) -> InvalidInputError:
    """Return the error for the first value in these rows that is not a number."""
    i, j, value = next(
        (i, j, value) for i, row in enumerate(rows) for j, value in enumerate(row) if type(value) not in allowed
    )
    return InvalidInputError(f"{name} row {i}, column {j} is not a number: {_described(value)}", (name, i, j))


def _described(value: object) -> str:
    """Return a JSON value as a message shows it: lists and objects by their kind, as they may be nested deeply.

    >>> [_described(value) for value in (None, "two", [[]], {})]
    ['null', '"two"', 'a list', 'an object']
    """
    if isinstance(value, list):
        return "a list"
    if isinstance(value, dict):
        return "an object"
    return shortened(orjson.dumps(value).decode())


def _packed(value: dict[str, Any], name: str, max_points: int) -> Array:
    """Return the array of {"dtype": "<f8", "shape": [n, d], "data": base64}."""
    if value.keys() != {"dtype", "shape", "data"}:
        raise InvalidInputError(f"{name} must have dtype, shape and data, and nothing else", (name,))
    shape = value["shape"]
    if not isinstance(shape, list) or any(type(n) is not int for n in shape):
        raise InvalidInputError(f"{name} must have a shape of two integers", (name, "shape"))
    if not isinstance(value["dtype"], str) or not isinstance(value["data"], str):
        raise InvalidInputError(f"dtype and data of {name} must be strings", (name,))
    try:
        dtype = number_type(value["dtype"])
    except ValueError as error:
        raise InvalidInputError(f"{name}: {error}", (name, "dtype")) from error
    try:
        data = base64.b64decode(value["data"], validate=True)
    except ValueError as error:
        raise InvalidInputError(f"data of {name} must be base64: {error}", (name, "data")) from error
    return doubles(shaped(data, dtype, tuple(shape), name, max_points))
