"""A program that a supervisor keeps running."""

import os
import subprocess
import sys
from pathlib import Path

from tests.service.running import children

COMMAND = Path(sys.executable).parent / "ipfit"
# Short leases, so that fits of a dead process run again within seconds; a queue that is small enough to become full;
# parts of a fit that take some tenths of a second.
SETTINGS: dict[str, object] = {
    "WORKERS": 1,
    "SHORT_WORKERS": 1,
    "LEASE": 5,
    "QUEUE_LIMIT": 12,
    "CLIENT_SHARE": 1,  # all callers have one address
    "SHUTDOWN_GRACE": 1,
    "TASKS_PER_WORKER": 20,
    "SPLIT_POINTS": 20_000,
}


class Program:
    """One `ipfit` command, which can be started again when it has ended."""

    def __init__(self, command: str, log: Path, settings: dict[str, object]) -> None:
        self._command, self._log = command, log
        self._settings = {f"IPFIT_{name}": str(value) for name, value in (SETTINGS | settings).items()}
        self._settings["TMPDIR"] = str(log.parent)  # what the killed leave behind goes when the run is over
        self.process: subprocess.Popen[bytes] | None = None
        self.starts = 0

    def run(self) -> None:
        """Start it, unless it is running."""
        if self.process is None or self.process.poll() is not None:
            self.starts += 1
            with self._log.open("ab") as log:
                self.process = subprocess.Popen(  # noqa: S603 - our own command
                    [COMMAND, self._command], env=os.environ | self._settings, stdout=log, stderr=log
                )

    @property
    def pid(self) -> int | None:
        """Return the id of its process, if it is running."""
        return self.process.pid if self.process is not None and self.process.poll() is None else None

    def fork_servers(self) -> list[int]:
        """Return the ids of the fork servers, which are the parents of its workers."""
        return [] if self.pid is None else [one for one in children(self.pid) if children(one)]

    def trackers(self) -> list[int]:
        """Return the ids of Python's resource trackers."""
        return [] if self.pid is None else [one for one in children(self.pid) if not children(one)]

    def workers(self) -> list[int]:
        """Return the ids of the worker processes."""
        return [] if self.pid is None else [worker for one in children(self.pid) for worker in children(one)]
