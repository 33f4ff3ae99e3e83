"""Counting connections by address, and telling the log what was refused without filling it."""

import logging
import time
from collections import Counter

from service.connections.limits import ConnectionLimits

logger = logging.getLogger(__name__)

# Seconds between two lines of the log about refusals of one kind.
LOG_SECONDS = 10.0


class Census:
    """The connections of a server that are open, and the requests that were refused."""

    def __init__(self, limits: ConnectionLimits) -> None:
        """Count against these limits."""
        self._limits = limits
        self._open: Counter[str] = Counter()
        self._refusals: Counter[str] = Counter()
        self._unlogged: Counter[str] = Counter()
        self._logged: dict[str, float] = {}

    @property
    def open(self) -> int:
        """Return the number of connections that are open."""
        return self._open.total()

    @property
    def refusals(self) -> dict[str, int]:
        """Return how many requests were refused, by the type of the problem."""
        return dict(self._refusals)

    def refuse(self, code: str) -> None:
        """Count a request that is refused."""
        self._refusals[code] += 1

    def enter(self, address: str) -> str | None:
        """Count a new connection; return why it has to be refused, or None if it may stay."""
        self._open[address] += 1
        if self._open.total() > self._limits.connections:
            return f"all {self._limits.connections} connections of this server are in use"
        if self._open[address] > self._limits.connections_of_address and not self._limits.is_trusted(address):
            return f"{self._limits.connections_of_address} connections from one address are the most here"
        return None

    def leave(self, address: str) -> None:
        """Count a connection that has ended."""
        self._open[address] -= 1
        if self._open[address] <= 0:
            del self._open[address]

    def log(self, kind: str, address: str) -> None:
        """Log a refusal of this kind, at most once in `LOG_SECONDS`, with the number since the last line."""
        self._unlogged[kind] += 1
        now = time.monotonic()
        if now - self._logged.get(kind, -LOG_SECONDS) < LOG_SECONDS:
            return
        logger.warning("%s (%d times, last from %s)", kind, self._unlogged.pop(kind), address or "unknown")
        self._logged[kind] = now
