"""The errors that the use cases raise. `service.api.problems` has the one table from these to HTTP statuses."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from service.jobs.admission import Allowance


class JobError(Exception):
    """Base of the errors below; the message is for the caller."""


class FitNotFoundError(JobError):
    """No fit has this id: it never existed, or was removed."""


class FitNotFinishedError(JobError):
    """The fit has no result yet."""


class FitWithoutResultError(JobError):
    """The fit ended without a result: it failed or was dismissed."""


class DeadlineExceededError(JobError):
    """The work took longer than its deadline, and its worker was killed."""


class WorkerCrashedError(JobError):
    """The worker process died in the middle of the work."""


class OutOfMemoryError(JobError):
    """The work needed more memory than a worker may take."""


class InvalidInputError(JobError):
    """The request cannot be carried out: its points cannot be fitted, or an option or a parameter is not allowed.

    Attributes
    ----------
    at
        The place in the request, outermost first: `("points", 17, 1)`.

    """

    def __init__(self, message: str, at: tuple[str | int, ...] = ()) -> None:
        """Take the message and the place."""
        super().__init__(message)
        self.at = at

    def __reduce__(self) -> tuple[type["InvalidInputError"], tuple[str, tuple[str | int, ...]]]:
        """Pickle with both arguments: errors are raised in workers and travel to the server."""
        return type(self), (str(self), self.at)


class MalformedInputError(InvalidInputError):
    """The body is not what its media type says: it cannot be read at all."""


class TooLargeError(InvalidInputError):
    """The input is over a limit of this server."""


class NotReadyError(JobError):
    """Something that fits need is not available at the moment: the database, the point sets, or room on the disk."""


class QueueFullError(JobError):
    """As many fits wait as the limit of this server allows.

    Attributes
    ----------
    retry_after
        Seconds after which one of them will probably have been started.

    """

    def __init__(self, message: str, retry_after: float) -> None:
        """Take the message and the time."""
        super().__init__(message)
        self.retry_after = retry_after


class QuotaExceededError(JobError):
    """The caller has used up a quota; others may go on.

    Attributes
    ----------
    allowances
        What the caller may still send, one `service.jobs.admission.Allowance` for each quota.
    retry_after
        Seconds after which there will probably be room again.

    """

    def __init__(self, message: str, allowances: Sequence["Allowance"], retry_after: float) -> None:
        """Take the message, the allowances and the time."""
        super().__init__(message)
        self.allowances, self.retry_after = allowances, retry_after


class UnauthorizedError(JobError):
    """The request has no API key, or one that is not known here."""


class KeyReusedError(JobError):
    """An idempotency key was sent before with another point set, other options or another callback."""


class ShuttingDownError(JobError):
    """The server is stopping and accepts nothing new."""


def json_pointer(at: Iterable[str | int]) -> str:
    """Return a place in a JSON document as a JSON pointer (RFC 6901).

    >>> json_pointer(("points", 17, 1))
    '/points/17/1'
    """
    return "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in at)
