"""The parameters of the fit routes: path, query and headers."""

import re
from math import isfinite
from typing import Annotated

from fastapi import Path, Query, Request
from pydantic import Field

from service.api.problems import HeaderError
from service.api.schema_types import FIT_ID_SCHEMA
from service.choices import OneOf
from service.jobs.bounds import HEAD_BYTES, MOST_RESOLUTION
from service.jobs.errors import InvalidInputError
from service.jobs.fit import FitStatus
from service.jobs.media_types import POINT_SET_FORMATS, ZERO_SET_FORMATS, Missing, zero_set_formats
from service.options import FitOptions
from service.problem_types import PROBLEM_TYPES

LONGEST_CALLBACK = 2000  # characters of its URL
LONGEST_KEY = 200  # characters of an Idempotency-Key
_QUOTED = re.compile(r'"((?:[\x20-\x21\x23-\x5b\x5d-\x7e]|\\["\\])*)"')
LARGEST_BOUND = 1e150  # as for points: the square of a larger one is not finite
_NUMBER = r" *[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)? *"
BOUNDS = rf"^{_NUMBER}(,{_NUMBER}){{3}}((,{_NUMBER}){{2}})?$"
_ROLE = r"\s*([nN]?[xXyYzZ]|_)\s*"
COLUMNS = f"^{_ROLE}(,{_ROLE})*$"


# The parameters of FitQuery that say how to read the body, and all that are no options of the fit.
READING = {"format", "columns", "missing"}
NO_OPTIONS = READING | {"callback"}


CallbackUrl = Annotated[str, Field(max_length=LONGEST_CALLBACK, json_schema_extra={"format": "uri"})]


class FitQuery(FitOptions):
    """The query of `POST /v1/fits`: options, how to read the body, and whom to tell of the end."""

    format: Annotated[str, OneOf(known.name for known in POINT_SET_FORMATS)] | None = Field(
        None, description="What the body is; wins over Content-Type."
    )
    columns: Annotated[str, Field(json_schema_extra={"maxLength": HEAD_BYTES, "pattern": COLUMNS})] | None = Field(
        None,
        description="What each column of a table or an npy array holds, in order: `x`, `y`, `z`, `nx`, `ny`, `nz`, or "
        "`_` for a column to ignore. Default: as its header says, else by the rules in docs/input.md.",
        examples=["x,y,z,_"],
    )
    missing: Missing = Field(
        "refuse",
        description="`refuse` refuses a point with a value that is missing or not finite; `drop` leaves such points "
        "out.",
    )
    callback: CallbackUrl | None = Field(
        None,
        description="An https URL to which the server POSTs a signed message when the fit has ended. Percent-encode "
        "it. Public addresses only; 422 if this server sends no callbacks.",
        examples=["https://hooks.example/fits"],
    )


def _names(dimension: int) -> str:
    return ", ".join(known.name for known in zero_set_formats(dimension))


# What is no id is answered with 404, as an id of no fit is, and not with 422.
FitId = Annotated[str, Path(description="The id that POST /v1/fits gave.", json_schema_extra=FIT_ID_SCHEMA)]
ProblemCode = Annotated[
    str, Path(description="The `code` of a problem.", json_schema_extra={"enum": list(PROBLEM_TYPES)})
]
Purge = Annotated[bool, Query(description="Whether to remove the fit, with its points, and not only to end it.")]
Status = Annotated[
    Annotated[str, OneOf(FitStatus)] | None, Query(description="Only fits of this status. Default: all.")
]
Limit = Annotated[int, Query(ge=1, le=100, description="Fits on a page, at most.")]
Cursor = Annotated[
    str | None,
    Query(
        max_length=200,
        pattern="^[A-Za-z0-9_-]*$",
        description="Where a page begins, from the `next` of the page before.",
    ),
]
PointSetFormatName = Annotated[
    Annotated[str, OneOf(known.name for known in POINT_SET_FORMATS)] | None,
    Query(description="The format; wins over Accept. Default: `npy`, as the points are stored."),
]
ZeroSetFormatName = Annotated[
    Annotated[str, OneOf(known.name for known in ZERO_SET_FORMATS)] | None,
    Query(description=f"The file kind; wins over Accept. 3D: {_names(3)}. 2D: {_names(2)}."),
]
Resolution = Annotated[
    int | None,
    Query(
        ge=4,
        le=MOST_RESOLUTION,
        description="Grid points along the longest axis. Default: 256 (2D) or 96 (3D), and more where the zero set is "
        "thin. If one is asked for that is too coarse, the response has the header `Zero-Set-Warning`.",
    ),
]
Bounds = Annotated[
    Annotated[str, Field(json_schema_extra={"maxLength": HEAD_BYTES, "pattern": BOUNDS})] | None,
    Query(
        description="Lower, then upper corner: 4 (2D) or 6 (3D) numbers with commas between, caller's coordinates. "
        "Default: the fit's own bounds.",
        examples=["-1,-1,1,1"],
    ),
]
Extent = Annotated[
    str,
    OneOf(["data", "bounds"]),
    Query(description="`data` leaves out what lies away from the points; `bounds` keeps everything in the bounds."),
]


def corners(bounds: str, dimension: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the lower and the upper corner, d numbers each, from the text `x,y,…,X,Y,…`.

    Raises
    ------
    InvalidInputError
        If it is not 2d finite numbers, a lower one is not below its upper one, or one is too large to compute with.

    >>> corners("-1,-2,3,4", 2)
    ((-1.0, -2.0), (3.0, 4.0))
    """
    numbers = tuple(map(float, bounds.split(","))) if re.fullmatch(BOUNDS, bounds) else ()
    lower, upper = numbers[:dimension], numbers[dimension:]
    ordered = len(upper) == dimension and all(a < b for a, b in zip(lower, upper, strict=True))
    if not ordered or not all(map(isfinite, numbers)):
        raise InvalidInputError(
            f"bounds must be {2 * dimension} finite numbers with commas between, every lower one below its upper one",
            ("bounds",),
        )
    if max(map(abs, numbers)) > LARGEST_BOUND:
        raise InvalidInputError(f"bounds may be as large as {LARGEST_BOUND:g}", ("bounds",))
    return lower, upper


def idempotency_key(request: Request) -> str | None:
    """Return the Idempotency-Key of a request, a quoted string (RFC 9651, 3.3.3), or None if it has none.

    Raises
    ------
    HeaderError
        If there are two, or it is not a string of 1 to `LONGEST_KEY` characters.

    """
    sent = request.headers.getlist("idempotency-key")
    if not sent:
        return None
    found = _QUOTED.fullmatch(sent[0].strip(" ")) if len(sent) == 1 else None
    key = "" if found is None else re.sub(r"\\(.)", r"\1", found.group(1))
    if not 0 < len(key) <= LONGEST_KEY:
        raise HeaderError(
            "Idempotency-Key",
            f"Idempotency-Key must be one quoted string of 1 to {LONGEST_KEY} printable ASCII characters, as in "
            '"torus-1" with its quotes',
        )
    return key
