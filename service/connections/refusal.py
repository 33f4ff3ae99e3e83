"""A refusal: a whole response, with problem details, for a peer whose request never reaches the application."""

import json
from dataclasses import dataclass, field

from service.problem_types import PROBLEM_TYPES
from service.request_ids import RequestIds


def _no_header(_name: str) -> None:
    """Return None: the headers of a request that is refused are not read."""


@dataclass(frozen=True)
class Refusal(Exception):  # noqa: N818 - raised in callbacks of the parser, to stop it
    """Why a request is refused before it reaches the application.

    Attributes
    ----------
    code
        The type of problem.
    detail
        What is wrong, for the caller.
    ids
        The names of the request.

    """

    code: str
    detail: str
    ids: RequestIds = field(default_factory=lambda: RequestIds.of(_no_header))

    def response(self, root: str = "") -> bytes:
        """Return the bytes of the response, for a server under the path `root`; the connection is closed after it."""
        kind = PROBLEM_TYPES[self.code]
        assert kind.status is not None  # noqa: S101 - the type of a failed fit refuses no request
        body = json.dumps(
            {
                "type": kind.path(root),
                "code": self.code,
                "title": kind.title,
                "status": int(kind.status),
                "detail": self.detail,
                "errors": [],
                "trace_id": self.ids.trace_id,
                "request_id": self.ids.request_id,
            }
        ).encode()
        headers = {
            "content-type": "application/problem+json",
            "content-length": str(len(body)),
            "cache-control": "no-store",
            "x-content-type-options": "nosniff",
            "x-frame-options": "DENY",
            "content-security-policy": "default-src 'none'; frame-ancestors 'none'; sandbox",
            "connection": "close",
            **self.ids.headers,
        }
        if kind.retry_after is not None:
            headers["retry-after"] = str(kind.retry_after)
        lines = [
            f"HTTP/1.1 {int(kind.status)} {kind.status.phrase}",
            *(f"{key}: {value}" for key, value in headers.items()),
        ]
        return "\r\n".join([*lines, "", ""]).encode("ascii") + body
