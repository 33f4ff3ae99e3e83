"""What the use cases need from the outside, as Protocols; `service.bootstrap` puts the real ones in."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeVar

import ipcore
from service.jobs.fit import Failure, Fit, FitStatus, Holder, PointSet
from service.jobs.mesh_request import MeshRequest

T = TypeVar("T")


class FitStore(Protocol):
    """Fits, durable. Every method is one transaction; a move that the table of moves forbids changes nothing."""

    def add(self, fit: Fit, keep: Callable[[], object], parts: Sequence[Fit] = ()) -> Fit:
        """Store a new fit with its parts and return it, or the fit that came earlier with the same key and payload.

        `keep` stores its input, at a moment when nobody can be removing it. When this returns, both survive a crash.

        Raises
        ------
        KeyReusedError
            If the key came with another payload.
        QueueFullError
            If too many fits wait.

        """

    def get(self, fit_id: str) -> Fit | None:
        """Return the fit, or None."""

    def start(self, fit_id: str, holder: Holder) -> int | None:
        """Move to running, on a lease, and return the attempt, from 1; None if the fit does not wait.

        A running fit whose lease has run out counts as waiting: its holder is dead. With its first part a fit runs,
        too; it waits again, to be started itself, when the last one has ended.
        """

    def renew(self, fit_id: str, attempt: int, lease: float) -> bool:
        """Prolong the lease, if this attempt still holds the fit."""

    def release(self, fit_id: str, attempt: int, *, crashed: bool = False) -> bool:
        """Move from running back to accepted, if this attempt still holds the fit; count a crash if it was one."""

    def finish(
        self, fit_id: str, attempt: int, status: FitStatus, result: bytes | None, failure: Failure | None
    ) -> bool:
        """Move to a final status with its result or failure, if this attempt still holds the fit.

        Its parts go. If it is itself a part, it counts as summed, or its fit fails with it.
        """

    def sums(self, fit_id: str) -> list[bytes]:
        """Return what the parts of a fit resulted in, in their order."""

    def dismiss(self, fit_id: str) -> bool:
        """Move to dismissed, if the fit is live; its parts go."""

    def remove(self, fit_id: str, drop: Callable[[str], object]) -> bool:
        """Forget a fit that has ended, and `drop` its input if no other fit has the same."""

    def discard(self, key: str, drop: Callable[[str], object]) -> bool:
        """`drop` an input, at a moment when no fit can be coming with it, if no fit has it; return whether."""

    def unused(self, keys: Iterable[str]) -> list[str]:
        """Return those of the inputs that no fit has."""

    def waiting(self) -> list[Fit]:
        """Return the accepted fits and parts that are in line, oldest first."""

    def count_waiting(self) -> int:
        """Return how many fits are accepted and in line, some part of them or as a whole."""

    def recover(self) -> int:
        """Move every running fit back to accepted, when nobody else can be running any; return how many."""

    def report(self, fit_id: str, attempt: int, steps: list[dict[str, Any]]) -> bool:
        """Keep the degrees tried so far, if this attempt still holds the fit."""

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees that were reported."""

    def outdated(self, age: float, size: int) -> list[str]:
        """Return the ids of fits that ended `age` seconds ago, and of the oldest beyond `size` bytes of ended fits."""


class BlobStore(Protocol):
    """Bytes under the name of their SHA-256, durable. Picklable: workers read from it."""

    def put(self, content: bytes) -> str:
        """Store and return the key; when this returns they survive a crash."""

    def get(self, key: str, start: int | None = None, end: int | None = None) -> bytes:
        """Return the bytes, or some of them."""

    def delete(self, key: str) -> None:
        """Remove them, if they are there."""

    def keys(self) -> list[str]:
        """Return the key of everything that is there."""


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
        DeadlineExceededError, WorkerCrashedError, OutOfMemoryError
            If it took longer than `deadline` seconds, the process died, or it needed more memory than it may take.

        """


class FitQueue(Protocol):
    """Runs accepted fits, or sees that others do."""

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop, and nothing new is to be accepted."""

    async def drain(self, seconds: float) -> None:
        """Start nothing more, give what runs so much time to end, then let everybody who waits for a fit go."""

    def hurry(self) -> None:
        """End a drain at once."""

    def submit(self, fit: Fit) -> None:
        """See that the fit, or the part of one, is run."""

    def cancel(self, fit_id: str) -> None:
        """Kill the workers that run the fit and its parts, or take them out of the line."""

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""

    async def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a running fit."""


class Reader(Protocol):
    """Turns a body into a checked point set."""

    async def read(self, body: bytes | Path, kind: str) -> PointSet:
        """Read and check.

        Raises
        ------
        InvalidInputError
            If it cannot be fitted.

        """


class Planner(Protocol):
    """Predicts the time and memory of fits."""

    def plan(self, points: PointSet, options: ipcore.FitOptions) -> ipcore.Plan:
        """Return what a fit of these points with these options will take.

        Raises
        ------
        InvalidInputError
            If the options are not allowed for points of this dimension; `at` names one.

        """


class MeshExporter(Protocol):
    """Makes files of zero sets."""

    async def export(self, result: bytes, points: bytes, dimension: int, wanted: MeshRequest) -> bytes:
        """Return the file of the zero set of a fit, from its result as JSON and its point set as npy."""
