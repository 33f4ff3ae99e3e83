"""The errors that the use cases raise. `service.api.problems` has the one table from these to HTTP statuses."""

from collections.abc import Iterable


class JobError(Exception):
    """Base of the errors below; the message is for the caller."""


class FitNotFoundError(JobError):
    """No fit has this id: it never existed, or was removed."""


class FitNotFinishedError(JobError):
    """The fit has no answer yet."""


class FitWithoutResultError(JobError):
    """The fit ended without an answer: it failed or was dismissed."""


class DeadlineExceededError(JobError):
    """The work took longer than it may, and its worker was killed."""


class WorkerCrashedError(JobError):
    """The worker process died in the middle of the work."""


class OutOfMemoryError(JobError):
    """The work needed more memory than a worker may take."""


class InvalidInputError(JobError):
    """What the caller sent cannot be fitted or drawn.

    Attributes
    ----------
    at
        The place in what was sent, outermost first: `("points", 17, 1)`.

    """

    def __init__(self, message: str, at: tuple[str | int, ...] = ()) -> None:
        """Keep the sentence and the place."""
        super().__init__(message)
        self.at = at

    def __reduce__(self) -> tuple[type["InvalidInputError"], tuple[str, tuple[str | int, ...]]]:
        """Pickle with both arguments, for the way back from a worker."""
        return type(self), (str(self), self.at)


class MalformedInputError(InvalidInputError):
    """The body is not what its media type says: it cannot be read at all."""


class TooLargeError(InvalidInputError):
    """The input is over a limit of this server."""


class NotReadyError(JobError):
    """What fits need is away at the moment: the database, the point sets, room on the disk."""


class QueueFullError(JobError):
    """As many fits wait as this server lets wait.

    Attributes
    ----------
    retry_after
        Seconds after which one of them will probably have been started.

    """

    def __init__(self, message: str, retry_after: float) -> None:
        """Keep the sentence and the time."""
        super().__init__(message)
        self.retry_after = retry_after


class KeyReusedError(JobError):
    """An idempotency key came again with something else to fit."""


class ShuttingDownError(JobError):
    """The server is stopping and takes nothing new."""


def json_pointer(at: Iterable[str | int]) -> str:
    """Return a place in a JSON document as a JSON pointer (RFC 6901).

    >>> json_pointer(("points", 17, 1))
    '/points/17/1'
    """
    return "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in at)
