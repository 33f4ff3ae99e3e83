"""How fast a peer sends its requests and takes its responses."""

from service.connections.limits import ConnectionLimits

# So many bytes fewer waiting show that the peer reads; a response is written in steps of 64 kB.
_LEAST_TAKEN = 16 * 1024


class Pace:
    """The pace of one connection.

    Attributes
    ----------
    received
        Bytes of bodies that have arrived.
    taken
        How often the peer has taken most of what waited for it.

    """

    def __init__(self, limits: ConnectionLimits) -> None:
        """Start at rest."""
        self.received = self.taken = 0
        self._limits = limits
        self._head_since: float | None = None
        self._body_since, self._body_from, self._looked = 0.0, 0, 0.0
        self._waiting, self._taken, self._read_at = 0, 0, 0.0

    def wait_for_head(self, now: float) -> None:
        """Start to wait for the head of a request."""
        self._head_since = now

    def wait_for_body(self, now: float) -> None:
        """Start to wait for the body, after the head."""
        self._head_since = None
        self._body_since, self._body_from, self._looked = now, self.received, now

    def rest(self) -> None:
        """Wait for nothing: the request is complete, and the server has to answer."""
        self._head_since = None

    def head_is_late(self, now: float) -> bool:
        """Return whether the head should have arrived."""
        return self._head_since is not None and now - self._head_since > self._limits.head_seconds

    def body_is_late(self, now: float, *, paused: bool) -> bool:
        """Return whether the body has arrived at less than the least rate for the stall time.

        What came fast before does not count, nor does the time in which the server does not read (`paused`).
        """
        if paused:
            self._body_since += now - self._looked
        self._looked = now
        waited = now - self._body_since
        if waited <= self._limits.stall_seconds:
            return False
        late = self.received - self._body_from < waited * self._limits.least_rate
        self._body_since, self._body_from = now, self.received
        return late

    def reader_is_late(self, now: float, waiting: int) -> bool:
        """Return whether the peer has taken nothing worth mentioning of the `waiting` bytes for the stall time."""
        took = self._waiting - waiting > _LEAST_TAKEN
        if not waiting or took or self.taken != self._taken or not self._waiting:
            self._waiting, self._taken, self._read_at = waiting, self.taken, now
        return waiting > 0 and now - self._read_at > self._limits.stall_seconds
