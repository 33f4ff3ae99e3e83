"""Uvicorn's HTTP protocol, with limits on what a peer may send and on how slowly.

Uvicorn's own parser takes a head of any size, adds the trailers of a chunked body to the headers, takes a request with
two Hosts or with none, and waits for ever for a peer that is silent, sends a byte a minute or does not read. A request
that breaks a limit here is answered with problem details where that is possible, and its connection is closed. The
other parser that uvicorn knows, h11, keeps some of these limits by itself, and takes longer: load/PARSERS.md.
"""

import asyncio
from functools import partial
from typing import Any

from service.connections.census import Census
from service.connections.limits import ConnectionLimits
from service.connections.methods import KNOWN_METHODS, unknown_method
from service.connections.pace import Pace
from service.connections.refusal import Refusal
from service.connections.refusing import RefusingProtocol
from service.connections.turns import Turns

# Seconds between two looks at the pace of a connection.
LOOK_SECONDS = 1.0


def guarded(limits: ConnectionLimits, census: Census) -> Any:  # noqa: ANN401 - uvicorn calls what it takes for a class
    """Return what makes the protocol of each connection of one server, as the `http` of uvicorn's configuration."""
    return partial(GuardedProtocol, limits=limits, census=census, turns=Turns())


class GuardedProtocol(RefusingProtocol):
    """The protocol of one connection."""

    def __init__(self, *given: Any, limits: ConnectionLimits, **named: Any) -> None:  # noqa: ANN401 - uvicorn's
        """Take uvicorn's arguments, and the limits of the server."""
        super().__init__(*given, **named)
        self._limits = limits
        self._unknown_method: bytes | None = None
        self._in_head = self._began = False
        self._head_bytes = self._idle_bytes = 0  # of the head so far; and those after it that brought no body
        self._body: list[bytes] = []  # parts of what is being parsed
        self._pace = Pace(limits)
        self._look: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's
        """Start a connection."""
        super().connection_made(transport)
        if not self._is_refused():
            self._pace.wait_for_head(self.loop.time())
            self._look = self.loop.call_later(LOOK_SECONDS, self._look_at_pace)

    def connection_lost(self, exc: Exception | None) -> None:
        """End a connection."""
        if self._look is not None:
            self._look.cancel()
        super().connection_lost(exc)

    def parse(self, data: bytes) -> None:
        """Parse data, and count what belongs to a head or is no part of a body."""
        if self._is_refused():
            return
        self._began, before = False, self._pace.received
        if not self._in_head and not self._in_body:
            self._unknown_method = unknown_method(data)
        super().parse(data)
        self._pass_body_on()
        if self._is_refused():
            return
        if self._in_head and not self._began:
            self._count_head(len(data))
        elif self._in_body and self._pace.received == before:  # chunk extensions and trailers
            self._idle_bytes += len(data)
            if self._idle_bytes > self._limits.head_bytes:
                self._refuse(Refusal("bad-request", "the body's chunks say much and hold nothing"))

    def send_400_response(self, msg: str) -> None:
        """Answer a request that cannot be parsed, or that a callback of the parser refused."""
        refusal = Refusal("bad-request", msg.rstrip(".").lower())
        if self._unknown_method is not None:  # the parser only says that it cannot parse
            refusal = _unknown(self._unknown_method)
        self._refuse(self._refusal or refusal)

    def on_message_begin(self) -> None:
        """Start a request."""
        super().on_message_begin()
        self._in_head, self._in_body, self._began = True, False, True
        self._head_bytes = self._idle_bytes = 0
        self._pace.wait_for_head(self.loop.time())

    def on_url(self, url: bytes) -> None:
        """Take a part of the request's target."""
        super().on_url(url)
        if len(self.url) > self._limits.head_bytes:
            self._stop(self._too_large())

    def on_header(self, name: bytes, value: bytes) -> None:
        """Take a header; drop a trailer."""
        if not self._in_head:
            return
        super().on_header(name, value)
        if len(self.headers) > self._limits.head_fields:
            self._stop(self._too_large())

    def on_headers_complete(self) -> None:
        """Check the head, and start the application."""
        size = len(self.url) + sum(len(name) + len(value) + 4 for name, value in self.headers)
        if size > self._limits.head_bytes:
            self._stop(self._too_large())
        hosts = [value for name, value in self.headers if name == b"host"]
        if len(hosts) > 1 or (not hosts and self.parser.get_http_version() != "1.0"):
            self._stop(Refusal("bad-request", f"a request has one Host, not {len(hosts)}"))
        if self.parser.get_method() not in KNOWN_METHODS:
            self._stop(_unknown(self.parser.get_method()))
        self._in_head, self._in_body = False, True
        self._pace.wait_for_body(self.loop.time())
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        """Keep a part of the body until the piece is parsed.

        A piece may have 700 parts, and with each of them uvicorn copies all that the application has not taken yet.
        """
        self._pace.received += len(body)
        self._body.append(body)

    def on_message_complete(self) -> None:
        """End a request."""
        self._pass_body_on()
        self._in_body = False
        self._unknown_method = None
        self._pace.rest()
        super().on_message_complete()

    def _pass_body_on(self) -> None:
        """Give the application what has arrived of the body."""
        if self._body:
            body = b"".join(self._body)
            self._body.clear()
            super().on_body(body)

    def resume_writing(self) -> None:
        """Note that the peer has taken most of what waited for it."""
        self._pace.taken += 1
        super().resume_writing()

    def _look_at_pace(self) -> None:
        """Close the connection if the peer sends or reads too slowly; else look again."""
        if self.transport.is_closing():
            return
        now = self.loop.time()
        if self._pace.head_is_late(now) and not self._waits_here():
            self._slow("a head that does not arrive", "the head of the request did not arrive in time")
        elif self._in_body and self._body_is_late(now):
            self._slow("a body that arrives too slowly", "the body of the request arrives too slowly")
        elif self._pace.reader_is_late(now, self.transport.get_write_buffer_size()):
            self._census.log("closed: a response that is not read", self._address)
            self._abort()
        else:
            self._look = self.loop.call_later(LOOK_SECONDS, self._look_at_pace)

    def _waits_here(self) -> bool:
        """Return whether something of the peer waits in this server: a request, or what has arrived."""
        return bool(self.pipeline or self.flow.backlog) or not self._is_answered(self._running)

    def _body_is_late(self, now: float) -> bool:
        """Return whether the body arrives too slowly, of a request that is not answered yet."""
        paused = self.flow.read_paused or bool(self.pipeline or self.flow.backlog)
        return self._pace.body_is_late(now, paused=paused) and not self._is_answered(self.cycle)

    def _abort(self) -> None:
        """Close the connection at once; the application must then not go on to write."""
        if self._running is not None:
            self._running.disconnected = True
        self.pipeline.clear()
        self.transport.abort()

    def _slow(self, kind: str, detail: str) -> None:
        """Close the connection of a slow peer; answer it only if it sent a part of a request and has no answer yet."""
        self._census.log(f"closed: {kind}", self._address)
        if self._in_head or self._in_body:
            self._send_refusal(Refusal("request-timeout", detail))
        else:
            self.transport.close()

    def _count_head(self, size: int) -> None:
        self._head_bytes += size
        if self._head_bytes > self._limits.head_bytes:
            self._refuse(self._too_large())

    def _too_large(self) -> Refusal:
        return Refusal(
            "head-too-large",
            f"the request line and the headers may have {self._limits.head_bytes} bytes "
            f"and {self._limits.head_fields} fields together",
        )


def _unknown(method: bytes) -> Refusal:
    name = method[:64].decode("ascii", "replace")
    return Refusal("not-implemented", f"the method {name} is not known here")
