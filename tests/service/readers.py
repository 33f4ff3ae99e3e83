"""Point sets read of what a test sends."""

import json
from typing import Any

import pytest

from service.formats.points import decode
from service.jobs.errors import InvalidInputError
from service.jobs.fit import ReceivedPoints

MOST = 1000


def read(body: bytes | dict[str, Any], kind: str = "json") -> ReceivedPoints:
    return decode.read(body if isinstance(body, bytes) else json.dumps(body).encode(), kind, MOST)


def refused(body: bytes | dict[str, Any], kind: str = "json") -> InvalidInputError:
    with pytest.raises(InvalidInputError) as caught:
        read(body, kind)
    return caught.value
