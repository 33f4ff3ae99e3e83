"""Point sets as npy: an array (N, columns) of numbers, or N records whose fields have names.

The header is a Python literal that anyone may have written. It is believed only as far as the bytes behind it go, and
no type is read but real numbers of at most 8 bytes: no objects, so no pickles.
"""

import tokenize
from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np

from service.formats.points import columns
from service.formats.points.reading import Array, RawPoints, ReadOptions, check_count, doubles, number_type, shortened
from service.jobs.errors import InvalidInputError, MalformedInputError

Header = Callable[[BytesIO], tuple[tuple[int, ...], bool, np.dtype[Any]]]
HEADERS: dict[tuple[int, int], Header] = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
# What numpy raises when a header is no literal, or one that would not end.
NOT_NPY = (
    ValueError,
    TypeError,
    EOFError,
    SyntaxError,
    tokenize.TokenError,
    RecursionError,
    MemoryError,
    OverflowError,
    UserWarning,  # of a header from Python 2, where warnings are errors; elsewhere such a file is read
)
MESSAGE_LENGTH = 200  # of what numpy says about a header; it quotes the header, which may be long


def read_npy(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the points, and the normals if there are any, of an npy file.

    Raises
    ------
    MalformedInputError
        If the bytes are not an npy file of real numbers.
    InvalidInputError
        If it cannot be told which column or field is what; `columns` settles it.

    """
    points, normals = split(read_array(content, "points", options.max_points), options)
    return RawPoints(points, normals)


def split(table: Array, options: ReadOptions) -> tuple[Array, Array | None]:
    """Return points (N, d) and normals (N, d), or None, of numbers (N, columns) or of records (N,)."""
    names = table.dtype.names
    if names is None:
        if options.columns is not None:
            return columns.chosen(options.columns, table.shape[1]).split(table)
        return columns.from_values(table, unit=False).split(table)
    if options.columns is not None:
        found = columns.chosen(options.columns, len(names))
    else:
        found = columns.from_names(names, "the dtype")
    return numbers(table, found.points), numbers(table, found.normals) if found.normals else None


def numbers(records: Array, positions: tuple[int, ...]) -> Array:
    """Return the numbers (N, fields) in these fields of records (N,)."""
    names = records.dtype.names or ()
    for name in (names[i] for i in positions):
        try:
            number_type(records.dtype[name].str if records.dtype[name].subdtype is None else "several numbers")
        except ValueError as error:
            raise MalformedInputError(f"field {shortened(name)!r}: {error}", ("points",)) from error
    return np.stack([doubles(records[names[i]]) for i in positions], axis=1)


def read_array(content: bytes, name: str, max_points: int) -> Array:
    """Return the array of an npy file: doubles (N, columns), or records (N,) with named fields.

    Raises
    ------
    MalformedInputError
        If the bytes are not an npy file of real numbers.
    InvalidInputError
        If the array has another number of axes.
    TooLargeError
        If there are more than `max_points` rows.

    """
    file = BytesIO(content)
    try:
        version = np.lib.format.read_magic(file)
        if version not in HEADERS:
            raise ValueError(f"version {version[0]}.{version[1]} is not read here")
        shape, fortran_order, dtype = HEADERS[version](file)
        if dtype.names is None:
            number_type(dtype.str if dtype.subdtype is None else "several numbers")
        elif dtype.hasobject:
            raise ValueError("a field holds Python objects, which are not read")
    except NOT_NPY as error:
        raise MalformedInputError(
            f"not an npy file of real numbers: {shortened(str(error), MESSAGE_LENGTH)}", (name,)
        ) from error
    data = content[file.tell() :]
    if dtype.names is not None:
        return _records(data, dtype, shape, name, max_points)
    if fortran_order:
        return doubles(shaped(data, dtype, shape, name, max_points)).reshape(shape[::-1]).T
    return doubles(shaped(data, dtype, shape, name, max_points))


def _records(data: bytes, dtype: np.dtype[Any], shape: tuple[int, ...], name: str, max_points: int) -> Array:
    """Return bytes as records (N,); an array (N, 1) of records is one, too."""
    if len(shape) not in (1, 2) or (len(shape) == 2 and shape[1] != 1):
        raise InvalidInputError(f"{name} must have one record per point, not shape {list(shape)}", (name,))
    return shaped(data, dtype, (shape[0], 1), name, max_points)[:, 0]


def shaped(data: bytes, dtype: np.dtype[Any], shape: tuple[int, ...], name: str, max_points: int) -> Array:
    """Return bytes as an array of this shape, (N, columns), row after row, if they are exactly that many.

    Parameters
    ----------
    data, dtype, shape
        What a caller says about bytes: nothing of it is trusted.
    name
        Of the array, for messages.
    max_points
        More rows are refused.

    Raises
    ------
    InvalidInputError
        If there are not two axes, or one of them has no entry.
    TooLargeError
        If there are more rows than `max_points`.
    MalformedInputError
        If there are more or fewer bytes than the shape takes.

    """
    listed = shortened(str(list(shape)), 60)
    if len(shape) != 2 or any(type(n) is not int or n < 0 for n in shape):
        raise InvalidInputError(f"{name} must have two axes, one row per point, not shape {listed}", (name,))
    check_count(shape[0], max_points, name)
    if 0 in shape:
        raise InvalidInputError(f"{name} are empty: their shape is {listed}", (name,))
    expected = shape[0] * shape[1] * dtype.itemsize
    if len(data) != expected or expected == 0:
        raise MalformedInputError(
            f"{name} of shape {listed} and dtype {shortened(str(dtype), 60)} take {shortened(str(expected))} bytes, "
            f"but {len(data)} came",
            (name,),
        )
    return np.frombuffer(data, dtype).reshape(shape)
