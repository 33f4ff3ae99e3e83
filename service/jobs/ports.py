"""What the use cases need from the outside, as Protocols; `service.bootstrap` puts the real ones in."""

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from service.jobs.fit import Failure, Fit, FitStatus

T = TypeVar("T")


class FitStore(Protocol):
    """Fits, durable. Every move is one transaction, and one that the table of moves forbids changes nothing."""

    def add(self, fit: Fit) -> None:
        """Store a new fit; when this returns it survives a crash."""

    def get(self, fit_id: str) -> Fit | None:
        """Return the fit, or None."""

    def start(self, fit_id: str) -> int | None:
        """Move to running and return the attempt, from 1; None if the fit is not waiting."""

    def release(self, fit_id: str, attempt: int) -> bool:
        """Move from running back to accepted, if this attempt still holds it."""

    def finish(
        self, fit_id: str, attempt: int, status: FitStatus, result: bytes | None, failure: Failure | None
    ) -> bool:
        """Move to a final status with its result or failure, if this attempt still holds the fit."""

    def dismiss(self, fit_id: str) -> bool:
        """Move to dismissed, if the fit is live."""

    def remove(self, fit_id: str) -> bool:
        """Forget a fit that has ended."""

    def uses(self, key: str) -> bool:
        """Return whether any fit's input is this blob."""

    def waiting(self) -> list[str]:
        """Return the ids of accepted fits, oldest first."""

    def recover(self) -> int:
        """Move every running fit back to accepted, after a start; return how many."""


class BlobStore(Protocol):
    """Bytes under the name of their SHA-256, durable. Picklable: workers read from it."""

    def put(self, content: bytes) -> str:
        """Store and return the key; when this returns they survive a crash."""

    def get(self, key: str) -> bytes:
        """Return the bytes."""

    def delete(self, key: str) -> None:
        """Remove them, if they are there."""


class Workers(Protocol):
    """Processes that run functions."""

    async def run(
        self,
        function: Callable[..., T],
        *arguments: object,
        deadline: float | None = None,
        progress: Callable[[Any], None] | None = None,
    ) -> T:
        """Run a module-level function in a process and return what it returns; cancelling kills the process.

        Raises
        ------
        DeadlineExceededError, WorkerCrashedError
            If it took longer than `deadline` seconds, or the process died.

        """


class FitQueue(Protocol):
    """Runs accepted fits."""

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop, and nothing new is to be accepted."""

    def stop(self) -> None:
        """Let everybody who waits for a fit go: the server is about to stop."""

    def submit(self, fit_id: str) -> None:
        """See that the fit is run."""

    def cancel(self, fit_id: str) -> None:
        """Kill the worker that runs the fit, or take it out of the line."""

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a running fit."""
