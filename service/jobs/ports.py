"""What the domain needs from outside for its work, as Protocols: `store_ports` has what it stores with.

`service.bootstrap` connects the adapters.
"""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any, Protocol, TypeVar

import ipcore
from service.jobs.exported_file import ExportedFile
from service.jobs.fit import Fit, PointSetRef, ReceivedPoints
from service.jobs.mesh_request import MeshRequest
from service.jobs.read_request import ReadRequest

T = TypeVar("T")


class Workers(Protocol):
    """A pool of processes that run functions."""

    async def run(
        self,
        function: Callable[..., T],
        *arguments: object,
        deadline: float | None = None,
        progress: Callable[[Any], None] | None = None,
    ) -> T:
        """Run a module-level function in a process and return its result; cancelling kills the process.

        Raises
        ------
        DeadlineExceededError, WorkerCrashedError, OutOfMemoryError
            If it took longer than `deadline` seconds, the process died, or it needed more memory than allowed.

        """


class FitQueue(Protocol):
    """Runs accepted fits, or lets other processes run them."""

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop; nothing new is to be accepted then."""

    async def drain(self, seconds: float) -> None:
        """Start no more fits, give those that run so much time to end, then end every `wait`."""

    def end_drain(self) -> None:
        """End a drain at once."""

    def submit(self, fit: Fit) -> None:
        """Queue a fit, or a part of one."""

    def cancel(self, fit_id: str) -> None:
        """Kill the workers that run the fit and its parts, or remove them from the queue."""

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""

    async def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a running fit."""


class Reader(Protocol):
    """Reads point sets from the bodies of requests."""

    async def read(self, body: bytes | Path, asked: ReadRequest) -> ReceivedPoints:
        """Read a body, or the file that holds it, and check it.

        Raises
        ------
        InvalidInputError
            If it cannot be read or fitted.

        """


class Planner(Protocol):
    """Predicts the time and memory of fits."""

    def plan(self, points: ReceivedPoints, options: ipcore.FitOptions) -> ipcore.Plan:
        """Return what a fit of these points with these options will take.

        Raises
        ------
        InvalidInputError
            If the options are not allowed for points of this dimension; `at` names one.

        """


class Seats(Protocol):
    """A number of seats for work, and a bounded queue for them."""

    def taken(self, client: str) -> AbstractAsyncContextManager[None]:
        """Hold a seat; wait for it if need be, in turn with other clients.

        Raises
        ------
        QueueFullError
            If too many requests wait, or none of the seats became free in time.

        """


class Exports(Protocol):
    """Makes files of fits. Equal files are made once."""

    def zero_set_name(self, result: bytes, points: PointSetRef, wanted: MeshRequest) -> str:
        """Return the name of the file of a zero set: the same for the same polynomial, request and version."""

    async def zero_set(
        self, result: bytes, points: PointSetRef, wanted: MeshRequest, encoding: str | None, client: str
    ) -> ExportedFile:
        """Return the file of the zero set of a fit, from its result as JSON, compressed if `encoding` is given.

        Raises
        ------
        InvalidInputError, TooLargeError, NotReadyError, QueueFullError
            If it cannot be extracted, is too large, its points cannot be read, or too many files are wanted.

        """

    async def points(self, points: PointSetRef, form: str, encoding: str | None, client: str) -> ExportedFile:
        """Return a point set as a file of the format `form`, compressed if `encoding` is given."""
