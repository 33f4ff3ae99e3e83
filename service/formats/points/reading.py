"""What every reader of point sets is given besides the bytes, what it returns, and the checks that they share."""

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from service.jobs.errors import InvalidInputError, TooLargeError
from service.jobs.media_types import Missing

Array = NDArray[Any]
# numpy's names of real numbers of at most 8 bytes. No other type is read: objects would be pickles, which run code.
REAL_NUMBER = re.compile(r"[<>|=]?(i[1248]|u[1248]|f[248])")


@dataclass(frozen=True)
class ReadOptions:
    """How a point set is to be read.

    Attributes
    ----------
    max_points
        More points are refused.
    columns
        What each column of a table holds, in order: `x`, `y`, `z`, `nx`, `ny`, `nz`, or `_` for a column to ignore.
        None leaves it to the header and the rules in `columns`.
    missing
        `refuse` refuses a point with a value that is missing or not finite; `drop` leaves such points out.

    """

    max_points: int
    columns: tuple[str, ...] | None = None
    missing: Missing = "refuse"


@dataclass(frozen=True)
class RawPoints:
    """Points as a reader found them, not yet checked.

    Attributes
    ----------
    points
        (N, d) numbers.
    normals
        (N, d) numbers, or None if there are none.
    options
        Fit options that stood in the same body, unchecked.

    """

    points: Array
    normals: Array | None = None
    options: dict[str, Any] = field(default_factory=dict)


def check_count(count: int, max_points: int, name: str = "points") -> None:
    """Refuse more than `max_points` points.

    Raises
    ------
    TooLargeError
        If `count` is larger.

    """
    if count > max_points:
        raise TooLargeError(f"{count} {name} are more than the {max_points} that this server takes", (name,))


def check_no_columns(options: ReadOptions, kind: str) -> None:
    """Refuse the option `columns` for a kind of file that names its values itself.

    Raises
    ------
    InvalidInputError
        If `columns` is given.

    """
    if options.columns is not None:
        raise InvalidInputError(
            f"columns is for tables and arrays; {kind} says itself what its values are", ("columns",)
        )


def number_type(name: str) -> np.dtype[Any]:
    """Return the numpy dtype of this name.

    Raises
    ------
    ValueError
        If it is not a real number of at most 8 bytes; the message says what it is instead.

    """
    if REAL_NUMBER.fullmatch(name) is None:
        complex_numbers = re.fullmatch(r"[<>|=]?c\d+", name) is not None
        hint = " (coordinates are real: send the real part)" if complex_numbers else ""
        raise ValueError(f"dtype must be an integer or a float of at most 8 bytes, not {shortened(name)}{hint}")
    return np.dtype(name)


def doubles(numbers: Array) -> Array:
    """Return numbers of any real type as doubles; a NaN of any kind is no reason for a warning here.

    >>> doubles(np.array([1, 2], dtype=">i2")).dtype.str[1:]
    'f8'
    """
    with np.errstate(invalid="ignore"):
        return numbers.astype(np.float64)


def shortened(text: str, length: int = 40) -> str:
    """Return the beginning of a caller's text, to be quoted in a message."""
    return text if len(text) <= length else f"{text[:length]}…"
