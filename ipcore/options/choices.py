"""What can be chosen by name in `FitOptions`."""

from enum import StrEnum
from numbers import Integral
from typing import TypeVar

from ipcore.errors import InvalidOptionsError

Choice = TypeVar("Choice", bound=StrEnum)


def chosen(name: str, value: object, kind: type[Choice]) -> Choice:
    """Return the member that a name stands for.

    Raises
    ------
    InvalidOptionsError
        If there is none; `at` is the option's name.

    """
    try:
        return kind(value)  # type: ignore[arg-type] # whatever it is, a wrong one raises ValueError
    except ValueError as error:
        raise InvalidOptionsError(f"{name} must be {' or '.join(kind)}, not {value!r}", (name,)) from error


class Preset(StrEnum):
    """Where the options start from.

    `default` is the fit that was found best by measurement. `paper` is Zheng, Takamatsu and Ikeuchi (ACCV 2007) to the
    letter: column by column, eq. (5), rule (7) after every column, and the ridge of section 5.3.
    """

    DEFAULT = "default"
    PAPER = "paper"


class Constraints(StrEnum):
    """Which equations the data give: one module of `ipcore.linear.constraints` each, with its formula and source."""

    THREE_LAYER = "3l"
    FIVE_LAYER = "5l"
    THREE_LAYER_GRADIENT = "3l+gradient"
    GRADIENT_ONE = "gradient-one"
    MIN_MAX = "min-max"
    MIN_VAR = "min-var"
    TAUBIN = "taubin"


class Criterion(StrEnum):
    """What ends the search.

    `distance` is the paper's rule (7). `gcv`, `bic` and `loo` look for the minimum of generalised cross-validation, of
    Schwarz' criterion, and of the mean squared error at points left out one by one. `none` goes on to `max_degree`.
    """

    DISTANCE = "distance"
    GCV = "gcv"
    BIC = "bic"
    LOO = "loo"
    NONE = "none"


class Granularity(StrEnum):
    """Where the search may stop: at complete degrees, which no rotation changes, or at every column as in the paper."""

    FORM = "form"
    MONOMIAL = "monomial"


class Factor(StrEnum):
    """How M = QR is computed.

    `moments` and `tsqr` never hold M: R is the Cholesky factor of MᵀM, whose entries are moments of the points, or is
    made of chunks of rows, factored one below the other. `moments` goes over to `tsqr` where squaring the condition
    would show. `block` is block Gram–Schmidt done twice on all of M, `gram-schmidt` the paper's eq. (5) as printed.
    `auto` is `moments` for large systems and `tsqr` for small ones, or `block` for what needs Q.
    """

    AUTO = "auto"
    MOMENTS = "moments"
    TSQR = "tsqr"
    BLOCK = "block"
    GRAM_SCHMIDT = "gram-schmidt"


class Collinear(StrEnum):
    """What becomes of a column that earlier ones explain: left out (section 5.2), ridged, or kept all the same."""

    DROP = "drop"
    RIDGE = "ridge"
    KEEP = "keep"


class Ridge(StrEnum):
    """Which columns ridge regression damps: none, every one (eq. 8), or only those found collinear."""

    NONE = "none"
    FULL = "full"
    SELECTIVE = "selective"


class RidgeMatrix(StrEnum):
    """D in eq. (8): the appendix's, which no rotation changes, or the identity."""

    INVARIANT = "invariant"
    IDENTITY = "identity"


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
