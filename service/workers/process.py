"""What a worker process does apart from its tasks: it connects, watches its server, and runs what it is given."""

import os
import resource
import time
from collections.abc import Callable
from threading import Thread
from typing import TypeVar

from service.jobs.errors import NotReadyError, OutOfMemoryError
from service.workers import progress

T = TypeVar("T")

# A worker that nobody waits for any more should not hold its core for long; looking once a second costs nothing.
LOOK = 1.0


def enter(address: str, memory: int) -> None:
    """Begin the life of a worker: take at most `memory` bytes, report to `address`, end when the server is gone."""
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    most = memory if hard == resource.RLIM_INFINITY else min(memory, hard)  # the system may have set less
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    progress.connect(address)
    Thread(target=_leave_with, args=(os.getppid(),), name="leave-with-server", daemon=True).start()


def run(task: str, function: Callable[..., T], arguments: tuple[object, ...]) -> T:
    """Run a function as this task.

    Raises
    ------
    OutOfMemoryError
        If it needs more memory than the process may take.
    NotReadyError
        If there is no room to write down which process works on it.

    """
    try:
        progress.begin(task)
    except OSError as error:
        raise NotReadyError(f"a worker cannot begin: {type(error).__name__}: {error.strerror}") from None
    try:
        return function(*arguments)
    except MemoryError as error:
        most = resource.getrlimit(resource.RLIMIT_DATA)[0]
        raise OutOfMemoryError(f"The work needs more than the {most} bytes that a worker may take: {error}") from None


def idle() -> None:
    """Do nothing: what is scheduled to find out that a worker has started."""


def _leave_with(parent: int) -> None:
    """End this process when the fork server has ended, which ends with the server, however that dies.

    A worker reads its tasks from a pipe and would notice only after the fit in hand, which may take minutes.
    """
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)
