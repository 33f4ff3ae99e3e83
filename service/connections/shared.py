"""Uvicorn's HTTP protocol, whose connections share the time of the event loop by address.

Uvicorn parses all that has arrived at once, and after each response reads on, however many requests of the connection
still wait: a client that sends requests without waiting for their answers keeps all others waiting, and fills the
memory. Here some kilobytes are parsed in a turn, and none while requests wait.
"""

import asyncio
import time
from typing import Any

from uvicorn._types import ASGI3Application
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle

from service.connections.flow import BacklogFlow
from service.connections.turns import Turns

# Bytes that are parsed at once. At worst they hold 700 chunks, for each of which the parser calls back.
PIECE = 4096
# Seconds of a turn, after which the next piece waits for the next turn. Bytes of a body take next to nothing.
TURN_SECONDS = 0.0003


class SharingProtocol(HttpToolsProtocol):
    """The protocol of one connection, which parses and starts requests when it is its address's turn."""

    flow: BacklogFlow  # narrower than uvicorn's

    def __init__(self, *given: Any, turns: Turns, **named: Any) -> None:  # noqa: ANN401 - uvicorn's
        """Take uvicorn's arguments, and the turns of the server."""
        super().__init__(*given, **named)
        self._turns = turns
        self._address = ""
        self._waits = self._responds = False  # for a turn; in the middle of uvicorn's end of a response

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's
        """Start a connection."""
        super().connection_made(transport)
        self._address = self.client[0] if self.client else ""
        self.flow = BacklogFlow(transport, self._go_on)

    def data_received(self, data: bytes) -> None:
        """Take data, to be parsed in turn."""
        self._unset_keepalive_if_required()
        self.flow.backlog += data
        self._go_on()

    def parse(self, data: bytes) -> None:
        """Parse some of what has arrived."""
        super().data_received(data)

    def on_response_complete(self) -> None:
        """Go on after a response: with the next request that waits, then with what has arrived."""
        self._responds = True
        super().on_response_complete()
        self._responds = False
        if self.flow.backlog:
            self._unset_keepalive_if_required()
        self._go_on()

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: ASGI3Application) -> None:
        """Start the application for one request, in turn, unless the peer has left meanwhile."""
        start = super()._start_asgi_task
        self._turns.take(self._address, lambda: None if self.transport.is_closing() else start(cycle, app))

    def _go_on(self) -> None:
        """Take a turn if something can be parsed, and read on if little waits and the application wants more."""
        if self._responds or self.transport.is_closing():
            return
        if not self._waits and self._can_parse():
            self._waits = True
            self._turns.take(self._address, self._take_turn)
        self.flow.listen(ready=not self.pipeline)

    def _can_parse(self) -> bool:
        return bool(self.flow.backlog) and not self.pipeline and not self.flow.read_paused

    def _take_turn(self) -> None:
        """Parse until the time of a turn is over, or a request waits."""
        end = time.monotonic() + TURN_SECONDS
        while not self.transport.is_closing() and self._can_parse():
            self.parse(self.flow.take(PIECE))
            if time.monotonic() > end:
                break
        self._waits = False
        self._go_on()
