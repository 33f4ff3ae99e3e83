"""Types of members of the JSON, each with the limits that the server keeps to."""

import re
from datetime import datetime
from typing import Annotated

from pydantic import BeforeValidator, Field, JsonValue

from service.jobs.bounds import LONGEST_ROOT_PATH, MOST_COEFFICIENTS

LARGEST_COUNT = 2**31 - 1
LONGEST_TEXT = 4000  # characters of a sentence for people
# What would break a line of a log or move the cursor of a terminal; callers send it, and messages quote callers.
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_PRINTABLE = r"^[^\x00-\x1f\x7f]*$"


def printable(text: str) -> str:
    r"""Return a message as it is sent: in one line, and not longer than `LONGEST_TEXT`.

    >>> printable("no such column: a\nb")
    'no such column: a b'
    """
    return _CONTROL.sub(" ", text if len(text) <= LONGEST_TEXT else f"{text[: LONGEST_TEXT - 1]}…")


Text = Annotated[str, Field(max_length=LONGEST_TEXT, pattern=_PRINTABLE), BeforeValidator(printable)]
Time = Annotated[datetime, Field(json_schema_extra={"maxLength": len("2007-11-18T09:00:00.000000Z")})]
FIT_ID_SCHEMA: dict[str, JsonValue] = {"minLength": 32, "maxLength": 32, "pattern": "^[0-9a-f]{32}$"}
FitIdText = Annotated[str, Field(json_schema_extra=FIT_ID_SCHEMA)]
TraceId = FitIdText  # both are 128 bits
PathText = Annotated[str, Field(max_length=LONGEST_ROOT_PATH + 1000, json_schema_extra={"format": "uri-reference"})]
RequestId = Annotated[str, Field(max_length=128, pattern=r"^[A-Za-z0-9._:+/=@-]+$")]
Sha256 = Annotated[str, Field(min_length=64, max_length=64, pattern="^[0-9a-f]{64}$")]
JsonPointer = Annotated[str, Field(max_length=1000, json_schema_extra={"format": "json-pointer"})]
Name = Annotated[str, Field(max_length=100, pattern=_PRINTABLE), BeforeValidator(printable)]

Count = Annotated[int, Field(ge=0, le=LARGEST_COUNT)]
ColumnCount = Annotated[int, Field(ge=0, le=MOST_COEFFICIENTS)]
EulerCharacteristic = Annotated[int, Field(ge=-LARGEST_COUNT, le=LARGEST_COUNT)]
Dimension = Annotated[int, Field(ge=2, le=3)]
Degree = Annotated[int, Field(ge=1, le=40)]
Exponent = Annotated[int, Field(ge=0, le=40)]

Vector = Annotated[list[float], Field(min_length=2, max_length=3)]
Exponents = Annotated[list[Exponent], Field(min_length=2, max_length=3)]
