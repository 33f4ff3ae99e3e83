"""A refusal: a whole response, with problem details, for a peer whose request never reaches the application."""

import json
from dataclasses import dataclass
from http import HTTPStatus
from uuid import uuid4

_TITLES = {
    HTTPStatus.BAD_REQUEST: "The request cannot be understood",
    HTTPStatus.REQUEST_TIMEOUT: "The request arrived too slowly",
    HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: "The request's head is too large",
    HTTPStatus.NOT_IMPLEMENTED: "The method is not known here",
    HTTPStatus.SERVICE_UNAVAILABLE: "Too many connections are open",
}
_KINDS = {
    HTTPStatus.BAD_REQUEST: "bad-request",
    HTTPStatus.REQUEST_TIMEOUT: "request-timeout",
    HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: "head-too-large",
    HTTPStatus.NOT_IMPLEMENTED: "not-implemented",
    HTTPStatus.SERVICE_UNAVAILABLE: "too-many-connections",
}


@dataclass(frozen=True)
class Refusal(Exception):  # noqa: N818 - raised in callbacks of the parser, to stop it
    """Why a request is refused before it reaches the application.

    Attributes
    ----------
    status
        400, 408, 431, 501 or 503.
    detail
        What is wrong, for the caller.
    retry_after
        Seconds after which to try again; None if that would not help.

    """

    status: HTTPStatus
    detail: str
    retry_after: int | None = None

    def response(self) -> bytes:
        """Return the bytes of the response; the connection is closed after it."""
        body = json.dumps(
            {
                "type": f"urn:ipfit:problem:{_KINDS[self.status]}",
                "title": _TITLES[self.status],
                "status": int(self.status),
                "detail": self.detail,
                "errors": [],
                "trace_id": uuid4().hex,
            }
        ).encode()
        lines = [
            f"HTTP/1.1 {int(self.status)} {self.status.phrase}",
            "content-type: application/problem+json",
            f"content-length: {len(body)}",
            "cache-control: no-store",
            "connection: close",
        ]
        if self.retry_after is not None:
            lines.append(f"retry-after: {self.retry_after}")
        return "\r\n".join([*lines, "", ""]).encode("ascii") + body
