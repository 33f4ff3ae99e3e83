"""The life of a worker process: its memory limit, its connection to the server, the tasks that it runs, its end."""

import os
import resource
import time
from collections.abc import Callable
from threading import Thread
from typing import TypeVar

from service.jobs.errors import NotReadyError, OutOfMemoryError
from service.workers import progress

T = TypeVar("T")

# Seconds between two looks whether the server still runs. A worker without one should free its core soon.
SERVER_CHECK_SECONDS = 1.0


def initialise(address: str, memory: int, niceness: int) -> None:
    """Start a worker that ends with the server: lower its priority, limit it to `memory` bytes, connect it."""
    os.nice(niceness)
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    most = memory if hard == resource.RLIM_INFINITY else min(memory, hard)  # the system may allow less
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    progress.connect(address)
    Thread(target=_exit_with, args=(os.getppid(),), name="exit-with-server", daemon=True).start()


def run(task: str, function: Callable[..., T], arguments: tuple[object, ...]) -> T:
    """Run a function as this task.

    Raises
    ------
    OutOfMemoryError
        If it needs more memory than the process may take.
    NotReadyError
        If the number of this process cannot be written, because the disk is full.

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
    """Do nothing. A worker that returns from this task has started."""


def _exit_with(parent: int) -> None:
    """End this process when the fork server, its parent, has ended; that ends with the server, however it dies.

    A worker reads its tasks from a pipe and would notice only after the running fit, which may take minutes.
    """
    while os.getppid() == parent:
        time.sleep(SERVER_CHECK_SECONDS)
    os._exit(1)
