"""The names of a request: its own id, and its place in a trace (W3C Trace Context).

They stand in every answer and in every line of the log that is written for the request.
"""

import re
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass, replace
from secrets import token_hex
from typing import Self

from opentelemetry.trace import SpanContext

_REQUEST_ID = re.compile(r"[A-Za-z0-9._:+/=@-]{1,128}")
_TRACEPARENT = re.compile(r"([0-9a-f]{2})-([0-9a-f]{32})-([0-9a-f]{16})-([0-9a-f]{2})(-.*)?")


@dataclass(frozen=True)
class RequestIds:
    """The names of one request.

    Attributes
    ----------
    request_id
        The caller's X-Request-Id, or one made here.
    trace_id, span_id
        The trace to which the request belongs, and this server's part of it: 32 and 16 hexadecimal digits.
    sampled
        Whether the trace is recorded: by the caller, or here (`within`).

    """

    request_id: str
    trace_id: str
    span_id: str
    sampled: bool = False

    @classmethod
    def of(cls, header: Callable[[str], str | None]) -> Self:
        """Return the names of a request, from the caller's headers where they are valid.

        >>> sent = {"x-request-id": "r1", "traceparent": f"00-{'a' * 32}-{'b' * 16}-01"}
        >>> ids = RequestIds.of(sent.get)
        >>> ids.request_id, ids.trace_id == "a" * 32, ids.sampled
        ('r1', True, True)
        """
        request_id = header("x-request-id") or ""
        trace, sampled = _trace(header("traceparent") or "")
        return cls(
            request_id if _REQUEST_ID.fullmatch(request_id) else token_hex(16),
            trace or token_hex(16),
            token_hex(8),
            sampled=sampled,
        )

    def within(self, span: SpanContext) -> Self:
        """Return these names with the place in a trace that a span has, if there is one: if OpenTelemetry is set up."""
        if not span.is_valid:
            return self
        trace_id, span_id = f"{span.trace_id:032x}", f"{span.span_id:016x}"
        return replace(self, trace_id=trace_id, span_id=span_id, sampled=span.trace_flags.sampled)

    @property
    def headers(self) -> dict[str, str]:
        """Return the headers of the answer."""
        flags = "01" if self.sampled else "00"
        return {"x-request-id": self.request_id, "traceparent": f"00-{self.trace_id}-{self.span_id}-{flags}"}


# The request on whose behalf the present task runs; None outside of requests.
CURRENT: ContextVar[RequestIds | None] = ContextVar("CURRENT", default=None)


def _trace(traceparent: str) -> tuple[str | None, bool]:
    """Return the id of the caller's trace and whether it is recorded; None if the header is not valid."""
    found = _TRACEPARENT.fullmatch(traceparent)
    if found is None:
        return None, False
    version, trace, parent, flags, more = found.groups()
    valid = version != "ff" and int(trace, 16) and int(parent, 16) and (more is None or version != "00")
    return (trace, bool(int(flags, 16) & 1)) if valid else (None, False)
