"""The bytes of bodies that are on their way in."""

from service.jobs.errors import QueueFullError

RETRY_SECONDS = 2.0


class Transit:
    """Counts the bytes of all bodies that are being received and read, so that they fit the memory and the disk."""

    def __init__(self, most: int) -> None:
        """Let at most so many bytes in at once."""
        self._most, self._bytes = most, 0

    def enter(self, size: int) -> None:
        """Count some bytes.

        Raises
        ------
        QueueFullError
            If they are too many.

        """
        if self._bytes + size > self._most:
            raise QueueFullError(f"bodies of {self._bytes} bytes are on their way in already", RETRY_SECONDS)
        self._bytes += size

    def leave(self, size: int) -> None:
        """Count some bytes that have been read, or given up."""
        self._bytes -= size
