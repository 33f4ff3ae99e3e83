"""Seats at which work is done now, and a bounded queue for them that is fair between clients."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from service.jobs.errors import QueueFullError

# The weight of the latest work in the mean time that one takes, from which Retry-After is computed.
LATEST = 0.3
FIRST_GUESS = 1.0  # seconds
# The share of the waiting places that one client may take.
SHARE_OF_A_CLIENT = 0.5


class FairSeats:
    """A number of seats. Who finds none waits; clients take turns, however much each of them asks for."""

    def __init__(self, name: str, seats: int, places: int, patience: float) -> None:
        """Make seats for the work called `name`; let at most `places` requests wait, each for `patience` seconds."""
        self._name, self._seats, self._free, self._places, self._patience = name, seats, seats, places, patience
        self._waiting: dict[str, deque[asyncio.Future[None]]] = {}  # in the order of the clients' turns
        self._seconds = FIRST_GUESS

    @asynccontextmanager
    async def taken(self, client: str) -> AsyncIterator[None]:
        """Hold a seat; wait for it if need be.

        Raises
        ------
        QueueFullError
            If too many requests wait, of all clients or of this one, or none of the seats became free in time.

        """
        await self._sit(client)
        clock = asyncio.get_running_loop().time
        began = clock()
        try:
            yield
            self._seconds += LATEST * (clock() - began - self._seconds)
        finally:
            self._leave()

    async def _sit(self, client: str) -> None:
        if self._free:
            self._free -= 1
            return
        self._check_room(client)
        turn = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(client, deque()).append(turn)
        try:
            async with asyncio.timeout(self._patience):
                await turn
        except BaseException as error:
            if turn.done() and not turn.cancelled():
                self._leave()  # the seat was given in the moment in which the wait ended
            self._forget(client, turn)
            if isinstance(error, TimeoutError):
                raise self._full(f"{self._name} took too long to begin") from error
            raise

    def _check_room(self, client: str) -> None:
        """Refuse to wait if all places are taken, or this client has its share of them."""
        waiting, own = self._count(), len(self._waiting.get(client, ()))
        if waiting >= self._places:
            raise self._full(f"{waiting} {self._name} wait already, as many as may")
        if own >= max(1, int(SHARE_OF_A_CLIENT * self._places)):
            raise self._full(f"{own} {self._name} of yours wait already, as many as may")

    def _full(self, message: str) -> QueueFullError:
        return QueueFullError(message, retry_after=max(1.0, self._seconds * (self._count() + 1) / self._seats))

    def _count(self) -> int:
        return sum(map(len, self._waiting.values()))

    def _forget(self, client: str, turn: asyncio.Future[None]) -> None:
        turns = self._waiting.get(client)
        if turns is not None and turn in turns:
            turns.remove(turn)
            if not turns:
                del self._waiting[client]

    def _leave(self) -> None:
        """Give the seat to the client whose turn it is, and let that client be the last; else keep it free."""
        while self._waiting:
            client = next(iter(self._waiting))
            turns = self._waiting.pop(client)
            turn = turns.popleft()
            if turns:
                self._waiting[client] = turns
            if not turn.done():
                turn.set_result(None)
                return
        self._free += 1
