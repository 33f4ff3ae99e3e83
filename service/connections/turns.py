"""Turns: the time of the event loop, shared between addresses and not between connections or requests."""

import asyncio
from collections import deque
from collections.abc import Callable

Work = Callable[[], None]


class Turns:
    """Lets each address do one piece of work in each round of the event loop, however many connections it has.

    A piece is the parsing of some kilobytes, or the start of one request. Between two rounds the loop does everything
    else that is due, so that a client who floods the server is answered as fast as possible, and others are answered
    in between. Nobody has to wait for a turn while there is nobody to share the time with.
    """

    def __init__(self) -> None:
        """Start with nobody waiting."""
        self._waiting: dict[str, deque[Work]] = {}
        self._served: set[str] = set()  # in this round
        self._next: asyncio.Handle | None = None

    def take(self, address: str, work: Work) -> None:
        """Do a piece of work now, if it is the first of this address in this round, else in one of the next."""
        if address in self._served or address in self._waiting:
            self._waiting.setdefault(address, deque()).append(work)
        else:
            self._served.add(address)
            work()
        if self._next is None:
            self._next = asyncio.get_running_loop().call_soon(self._round)

    def _round(self) -> None:
        """Give a turn to each address that waits."""
        addresses = list(self._waiting)
        self._served = set(addresses)
        self._next = asyncio.get_running_loop().call_soon(self._round) if addresses else None
        for address in addresses:
            waiting = self._waiting[address]
            work = waiting.popleft()
            if not waiting:
                del self._waiting[address]
            work()
