"""Refusing requests that never reach the application, in the order in which the peer sent them."""

import asyncio
from typing import Any

from uvicorn._types import ASGI3Application
from uvicorn.protocols.http.httptools_impl import RequestResponseCycle

from service.connections.census import Census
from service.connections.refusal import Refusal
from service.connections.shared import SharingProtocol

LINGER_SECONDS = 1.0  # from an answer that refuses a request to the end of its connection


class RefusingProtocol(SharingProtocol):
    """The protocol of one connection, which is counted, and whose requests may be refused.

    A refusal is the answer to the request that cannot be read, so it waits until the application has answered those
    before it. After it nothing more is parsed.
    """

    def __init__(self, *given: Any, census: Census, **named: Any) -> None:  # noqa: ANN401 - uvicorn's
        """Take uvicorn's arguments, and the census of the server."""
        super().__init__(*given, **named)
        self._census, self._counted = census, False
        self._refusal: Refusal | None = None
        self._running: RequestResponseCycle | None = None  # the last request that the application was given
        self._in_body = False  # between the head of a request and its end

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's
        """Start a connection, or refuse it if there are too many."""
        super().connection_made(transport)
        reason, self._counted = self._census.enter(self._address), True
        if reason is not None:
            self._refuse(Refusal("too-many-connections", reason))

    def connection_lost(self, exc: Exception | None) -> None:
        """End a connection."""
        self._leave()
        super().connection_lost(exc)

    def on_response_complete(self) -> None:
        """Go on after a response; refuse what could not be refused before it."""
        super().on_response_complete()
        if self._refusal is not None and not self.transport.is_closing() and not self._has_earlier():
            self._send_refusal(self._refusal)

    def _leave(self) -> None:
        """Count the connection as ended, once."""
        if self._counted:
            self._census.leave(self._address)
        self._counted = False

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: ASGI3Application) -> None:
        """Start the application for one request."""
        self._running = cycle
        super()._start_asgi_task(cycle, app)

    def _stop(self, refusal: Refusal) -> None:
        """Stop the parser, from within one of its callbacks; it then calls `send_400_response`."""
        self._refusal = refusal
        raise refusal

    def _is_refused(self) -> bool:
        return self._refusal is not None

    def _refuse(self, refusal: Refusal) -> None:
        """Answer the request that is being read with a refusal, after those before it, and close the connection."""
        self._refusal = refusal
        self._census.refuse(refusal.code)
        self._census.log(f"refused: {refusal.detail}", f"{self._address}, trace {refusal.ids.trace_id}")
        if self._in_body and self.pipeline and self.pipeline[0][0] is self.cycle:
            self.pipeline.popleft()  # the application is not given it
            self._in_body = False
        if not self._has_earlier():
            self._send_refusal(refusal)

    def _has_earlier(self) -> bool:
        """Return whether a request before the one that is refused is not answered yet."""
        own = self._in_body and self._running is self.cycle
        return bool(self.pipeline) or not (own or self._is_answered(self._running))

    @staticmethod
    def _is_answered(cycle: RequestResponseCycle | None) -> bool:
        return cycle is None or cycle.response_complete

    def _send_refusal(self, refusal: Refusal) -> None:
        """Write a refusal, unless the application has begun to answer the same request; it will not any more."""
        self._refusal = refusal
        own = self._running if self._in_body else None
        if own is None or not own.response_started:
            self.transport.write(refusal.response(self.root_path))
        elif not own.response_complete:
            self.transport.close()
        if own is not None:
            own.disconnected = True
            own.message_event.set()
        self._close_when_read()

    def _close_when_read(self) -> None:
        """Say that nothing more comes, and close a little later.

        If a socket is closed while data wait in it that were not read, the system resets the connection, and the peer
        may never see the answer. What still arrives is dropped, and the connection does not count any more.
        """
        if self.transport.is_closing():
            return
        self._leave()
        if self.transport.can_write_eof():
            self.transport.write_eof()
        self.loop.call_later(LINGER_SECONDS, self.transport.close)
