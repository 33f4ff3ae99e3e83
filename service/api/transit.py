"""The bytes of bodies that are on their way in."""

from collections import Counter

from service.jobs.errors import QueueFullError

RETRY_SECONDS = 2.0
SENDERS_SHARE = 0.5  # of the bytes that one client may have on the way


class Transit:
    """Counts the bytes of all bodies that are being received and read, so that they fit the memory and the disk."""

    def __init__(self, most: int) -> None:
        """Let at most so many bytes in at once."""
        self._most, self._bytes = most, 0
        self._of_client: Counter[str] = Counter()

    def enter(self, size: int, client: str) -> None:
        """Count some bytes of a client.

        Raises
        ------
        QueueFullError
            If they are too many, of all clients or of this one.

        """
        if self._bytes + size > self._most:
            raise QueueFullError(f"bodies of {self._bytes} bytes are on their way in already", RETRY_SECONDS)
        if self._of_client[client] + size > SENDERS_SHARE * self._most:
            raise QueueFullError(f"{self._of_client[client]} bytes of yours are on their way in already", RETRY_SECONDS)
        self._bytes += size
        self._of_client[client] += size

    def leave(self, size: int, client: str) -> None:
        """Count some bytes that have been read, or given up."""
        self._bytes -= size
        self._of_client[client] -= size
        if not self._of_client[client]:
            del self._of_client[client]
