"""Point sets in: JSON and npy, read without trusting a byte, checked, and turned into one npy of doubles."""

import base64
import re
import tokenize
from collections.abc import Callable
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

import ipcore
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from service.jobs.fit import PointSet
from service.jobs.slices import Frame

Array = NDArray[Any]
Parts = tuple[Array, Array | None, dict[str, Any]]
# numpy's names of real numbers of at most 8 bytes. Anything else numpy might understand is not for strangers.
NUMBER = re.compile(r"[<>|=]?(i[1248]|u[1248]|f[248])")

MEDIA_TYPES = {"application/json": "json", "application/x-npy": "npy"}


def read(body: bytes | Path, kind: str, max_points: int) -> PointSet:
    """Read and check a point set.

    Parameters
    ----------
    body
        The bytes, or a file that holds them.
    kind
        `json` or `npy`.
    max_points
        More are refused before they are turned into numbers.

    Raises
    ------
    MalformedInputError
        If the bytes are not of that kind.
    InvalidInputError
        If they are, but not a point set that can be fitted.
    TooLargeError
        If there are more points than `max_points`.

    """
    content = body if isinstance(body, bytes) else body.read_bytes()
    return checked(*READERS[kind](content, max_points), max_points)


def checked(points: Array, normals: Array | None, options: dict[str, Any], max_points: int) -> PointSet:
    """Return arrays that were read as a checked point set.

    Raises
    ------
    InvalidInputError
        If they cannot be fitted.
    TooLargeError
        If there are more points than `max_points`.

    """
    _limit(len(points), max_points, "points")
    try:
        given = ipcore.check_points(points, normals)
    except ipcore.IPCoreError as error:
        raise InvalidInputError(error.message, error.at) from error
    table = given.points if given.normals is None else np.hstack([given.points, given.normals])
    count, dimension = given.points.shape
    return PointSet(_npy(table), dimension, count, given.normals is not None, options, _frame(given))


def _frame(given: ipcore.PointSet) -> Frame | None:
    """Return the frame in which moments of parts of the points can be summed, if there will be any."""
    if given.normals is None or given.planar:
        return None
    frame = ipcore.Frame.of(given.points)
    return Frame(tuple(frame.centre.tolist()), frame.scale)


def halves(table: Array) -> tuple[Array, Array | None]:
    """Return points and normals from a table of 2 or 3 columns of points, or 4 or 6 of both.

    Raises
    ------
    InvalidInputError
        If it has another number of columns.

    """
    columns = table.shape[1]
    if columns not in (2, 3, 4, 6):
        raise InvalidInputError(
            f"there must be 2 or 3 columns of points, or 4 or 6 of points and normals, not {columns}", ("points",)
        )
    return (table, None) if columns in (2, 3) else (table[:, : columns // 2], table[:, columns // 2 :])


def split(content: bytes, dimension: int) -> tuple[Array, Array | None]:
    """Return points and normals, if any, from what `read` made."""
    table = np.load(BytesIO(content), allow_pickle=False)
    return table[:, :dimension], table[:, dimension:] if table.shape[1] > dimension else None


def _npy(table: Array) -> bytes:
    file = BytesIO()
    np.save(file, table, allow_pickle=False)
    return file.getvalue()


def _read_json(content: bytes, max_points: int) -> Parts:
    try:
        document = orjson.loads(content)
    except orjson.JSONDecodeError as error:
        raise MalformedInputError(f"not JSON: {error}") from error
    if not isinstance(document, dict):
        raise InvalidInputError("the body must be a JSON object with points, and optionally normals and options")
    unknown = min(document.keys() - {"points", "normals", "options"}, default=None)
    if unknown is not None:
        raise InvalidInputError(
            f"unknown member {_short(unknown)!r}; known are points, normals and options", (_short(unknown),)
        )
    if "points" not in document:
        raise InvalidInputError("points are missing", ("points",))
    options = document.get("options", {})
    if not isinstance(options, dict):
        raise InvalidInputError("options must be an object", ("options",))
    normals = document.get("normals")
    points = _array(document["points"], "points", max_points)
    return points, None if normals is None else _array(normals, "normals", max_points), options


def _array(value: object, name: str, max_points: int) -> Array:
    """Return an array from nested lists or from {dtype, shape, data}."""
    if isinstance(value, dict):
        return _packed(value, name, max_points)
    if not isinstance(value, list):
        raise InvalidInputError(f"{name} must be a list of rows, or an object with dtype, shape and data", (name,))
    _limit(len(value), max_points, name)
    if not value:
        raise InvalidInputError(f"{name} are empty", (name,))
    width = len(value[0]) if isinstance(value[0], list) else None
    for i, row in enumerate(value):
        if not isinstance(row, list) or len(row) != width:
            raise InvalidInputError(f"{name} row {i} must be a list of as many numbers as row 0", (name, i))
    # Looked at before numpy is: of one long string it would make an array in which every item is as long.
    if not set(map(type, chain.from_iterable(value))) <= {int, float}:
        raise InvalidInputError(*_not_a_number(value, name))
    return np.array(value, dtype=np.float64)


def _not_a_number(rows: list[list[Any]], name: str) -> tuple[str, tuple[str | int, ...]]:
    """Return which value in these rows is not a number."""
    i, j, value = next(
        (i, j, value) for i, row in enumerate(rows) for j, value in enumerate(row) if type(value) not in (int, float)
    )
    return f"{name} row {i}, column {j} is not a number: {_short(orjson.dumps(value).decode())}", (name, i, j)


def _short(text: str) -> str:
    """Return the beginning of what a stranger sent, to be told back."""
    return text if len(text) <= 40 else f"{text[:40]}…"


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
        kind = _number_type(value["dtype"])
    except ValueError as error:
        raise InvalidInputError(f"{name}: {error}", (name, "dtype")) from error
    try:
        data = base64.b64decode(value["data"], validate=True)
    except ValueError as error:
        raise InvalidInputError(f"data of {name} must be base64: {error}", (name, "data")) from error
    return _shaped(data, kind, tuple(shape), name, max_points)


def _read_npy(content: bytes, max_points: int) -> Parts:
    """Read d columns of points, or 2d of points and normals. The header is believed only as far as the bytes go."""
    file = BytesIO(content)
    try:
        version = np.lib.format.read_magic(file)
        if version not in HEADERS:
            raise ValueError(f"version {version[0]}.{version[1]} is not read here")
        shape, fortran_order, dtype = HEADERS[version](file)
        kind = _number_type(dtype.str)
    except NOT_NPY as error:
        raise MalformedInputError(f"not an npy file of numbers: {_short(str(error))}") from error
    table = _shaped(content[file.tell() :], kind, shape, "points", max_points)
    if fortran_order:
        table = table.reshape(shape[::-1]).T
    return *halves(table), {}


Header = Callable[[BytesIO], tuple[tuple[int, ...], bool, np.dtype[Any]]]
HEADERS: dict[tuple[int, int], Header] = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
# What numpy raises when a header, which is a Python literal, is none, or is one that would not end.
NOT_NPY = (
    ValueError,
    TypeError,
    EOFError,
    SyntaxError,
    tokenize.TokenError,
    RecursionError,
    MemoryError,
    OverflowError,
)


def _number_type(name: str) -> np.dtype[Any]:
    """Return a dtype of real numbers, refusing every other: no objects, so no pickles."""
    if NUMBER.fullmatch(name) is None:
        raise ValueError(f"dtype must be an integer or a float of at most 8 bytes, not {_short(name)}")
    return np.dtype(name)


def _shaped(data: bytes, dtype: np.dtype[Any], shape: tuple[int, ...], name: str, max_points: int) -> Array:
    """Return bytes as an array of doubles of this shape, if they are exactly that many."""
    if len(shape) != 2 or min(shape) < 0:
        raise InvalidInputError(f"{name} must have two axes, one row per point, not shape {list(shape)}", (name,))
    _limit(shape[0], max_points, name)
    expected = shape[0] * shape[1] * dtype.itemsize
    if len(data) != expected:
        raise MalformedInputError(
            f"{name} of shape {list(shape)} and dtype {dtype.str} take {expected} bytes, but {len(data)} came", (name,)
        )
    return np.frombuffer(data, dtype).reshape(shape).astype(np.float64)


def _limit(count: int, max_points: int, name: str) -> None:
    if count > max_points:
        raise TooLargeError(f"{count} {name} are more than the {max_points} that this server takes", (name,))


READERS: dict[str, Callable[[bytes, int], Parts]] = {"json": _read_json, "npy": _read_npy}
