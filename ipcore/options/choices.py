"""The options that take a name, one enumeration each, and the check of a name.

The constraint families, which take a name too, are enumerated in `ipcore.constraints.registry`.
"""

from enum import StrEnum
from typing import TypeVar

from ipcore.errors import InvalidOptionsError

Choice = TypeVar("Choice", bound=StrEnum)


def member(name: str, value: object, kind: type[Choice]) -> Choice:
    """Return the member of an enumeration for the value that was given for the option `name`.

    Raises
    ------
    InvalidOptionsError
        If the enumeration has no such value; `at` is the option's name.

    """
    try:
        return kind(value)  # type: ignore[arg-type] # whatever it is, a wrong one raises ValueError
    except ValueError as error:
        raise InvalidOptionsError(f"{name} must be {' or '.join(kind)}, not {value!r}", (name,)) from error


class Preset(StrEnum):
    """The set of defaults that the options given are put into.

    `default` is the fit that was found best by measurement. `paper` is Zheng, Takamatsu and Ikeuchi (ACCV 2007) to the
    letter: column by column, eq. (5), rule (7) after every column, and the ridge of section 5.3.
    """

    DEFAULT = "default"
    PAPER = "paper"


class Criterion(StrEnum):
    """What ends the search over degrees; one class of `ipcore.search.criteria` each.

    `distance` is the paper's rule (7). `gcv`, `bic` and `loo` look for the minimum of generalised cross-validation, of
    Schwarz' criterion, and of the mean squared error at points left out one by one. `none` goes on to `max_degree`.
    """

    DISTANCE = "distance"
    GCV = "gcv"
    BIC = "bic"
    LOO = "loo"
    NONE = "none"

    @property
    def needs_least_squares(self) -> bool:
        """Return whether its value is computed from the residuals of a linear least-squares fit."""
        return self not in {Criterion.DISTANCE, Criterion.NONE}

    @property
    def needs_rows(self) -> bool:
        """Return whether its value needs Q, and so all rows of M at once."""
        return self is Criterion.LOO


class Granularity(StrEnum):
    """Where the search may stop: at complete degrees, which no rotation changes, or at each column as in the paper."""

    FORM = "form"
    MONOMIAL = "monomial"


class Factor(StrEnum):
    """How M = QR is computed.

    `moments` and `tsqr` never hold M. With `moments`, R is the Cholesky factor of MᵀM, whose entries are moments of the
    points; where squaring the condition would show in the answer, the fit goes on with `tsqr`. With `tsqr`, R is made
    of chunks of rows, factored one below the other. `block` is block Gram–Schmidt done twice on all of M, and
    `gram-schmidt` is the paper's eq. (5) as printed. `auto` is `block` for fits that need Q, else `tsqr` for small
    systems and `moments` for large ones.
    """

    AUTO = "auto"
    MOMENTS = "moments"
    TSQR = "tsqr"
    BLOCK = "block"
    GRAM_SCHMIDT = "gram-schmidt"


class Collinear(StrEnum):
    """What is done with a column that depends on earlier ones: dropped (section 5.2), ridged, or kept all the same."""

    DROP = "drop"
    RIDGE = "ridge"
    KEEP = "keep"


class Ridge(StrEnum):
    """Which columns ridge regression damps: none, all of them (eq. 8), or only those found collinear."""

    NONE = "none"
    FULL = "full"
    SELECTIVE = "selective"


class RidgeMatrix(StrEnum):
    """D in eq. (8): the matrix of the appendix, for which no rotation changes aᵀDa, or the identity."""

    INVARIANT = "invariant"
    IDENTITY = "identity"
