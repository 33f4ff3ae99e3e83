"""Flow control with a backlog: what has arrived waits for its turn, and little more is read meanwhile."""

import asyncio
from collections.abc import Callable

from uvicorn.protocols.http.flow_control import FlowControl

# Bytes of a backlog below which the server goes on reading, and so sees that a peer has left: else a thousand small
# requests of such peers would be kept until their turn.
LITTLE = 4096


class BacklogFlow(FlowControl):
    """Uvicorn's flow control; when the application wants more of a body, that may already be in the backlog.

    Attributes
    ----------
    backlog
        What has arrived and was not parsed yet.

    """

    def __init__(self, transport: asyncio.Transport, wanted: Callable[[], None]) -> None:
        """Call `wanted` when there is something to go on with."""
        super().__init__(transport)
        self.backlog = bytearray()
        self._wanted, self._listens = wanted, True

    def resume_reading(self) -> None:
        """Let the protocol go on with the backlog, and then with the peer."""
        if self.read_paused:
            self.read_paused = False
            self._wanted()

    def take(self, size: int) -> bytes:
        """Take so many bytes from the backlog."""
        some = bytes(self.backlog[:size])
        del self.backlog[:size]
        return some

    def listen(self, *, ready: bool) -> None:
        """Read from the peer if little waits to be parsed and the protocol is ready for more, else do not."""
        listens = ready and len(self.backlog) < LITTLE and not self.read_paused
        if listens != self._listens:
            self._listens = listens
            (self._transport.resume_reading if listens else self._transport.pause_reading)()

    def pause_reading(self) -> None:
        """Parse and read nothing until reading is resumed."""
        self.read_paused = True
        self.listen(ready=False)
