"""Ranges of the numbers among the options."""

from numbers import Integral

from ipcore.errors import InvalidOptionsError


def integer(name: str, value: object, low: int, high: int) -> None:
    """Refuse what is not an integer from `low` to `high`.

    Raises
    ------
    InvalidOptionsError
        With `name` in `at`.

    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not low <= int(value) <= high:
        raise InvalidOptionsError(f"{name} must be an integer from {low} to {high}, not {value!r}", (name,))


def number(name: str, value: object, low: float, high: float, *, open_below: bool = False) -> None:
    """Refuse what is not a number from `low` to `high`, without `low` itself if the range is open below.

    Raises
    ------
    InvalidOptionsError
        With `name` in `at`.

    """
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not low <= value <= high
        or (open_below and value == low)
    ):
        bracket = "more than" if open_below else "at least"
        raise InvalidOptionsError(f"{name} must be a number {bracket} {low} and at most {high}, not {value!r}", (name,))
