"""The options that take a number: the range of each, and the checks of ranges."""

from numbers import Integral
from typing import NamedTuple

from ipcore.errors import InvalidOptionsError


class Range(NamedTuple):
    """The numbers from `low` to `high`, without `low` itself if the range is open below."""

    low: float
    high: float
    open_below: bool = False


RANGES = {
    "layer_distance": Range(0.0, 0.3, open_below=True),  # up to the margin of the bounds, which hold the layers
    "gradient_weight": Range(0.0, 100.0, open_below=True),
    "t1": Range(0.0, float("inf")),
    "t2": Range(-1.0, 1.0),
    "collinear_tol": Range(0.0, 1.0),
    "ridge_strength": Range(0.0, 1e6, open_below=True),
    "angle_weight": Range(0.0, 1.0, open_below=True),
}


def check_integer(name: str, value: object, low: int, high: int) -> None:
    """Check that the value of the option `name` is an integer from `low` to `high`.

    Raises
    ------
    InvalidOptionsError
        If it is not; `at` is the option's name.

    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not low <= int(value) <= high:
        raise InvalidOptionsError(f"{name} must be an integer from {low} to {high}, not {value!r}", (name,))


def check_number(name: str, value: object, allowed: Range) -> None:
    """Check that the value of the option `name` is a number in a range.

    Raises
    ------
    InvalidOptionsError
        If it is not; `at` is the option's name.

    """
    low, high, open_below = allowed
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not low <= value <= high
        or (open_below and value == low)
    ):
        bracket = "more than" if open_below else "at least"
        raise InvalidOptionsError(f"{name} must be a number {bracket} {low} and at most {high}, not {value!r}", (name,))
