"""Killing a process, and finding out whether it is dead."""

import os
import signal
from contextlib import suppress
from pathlib import Path


def kill(worker: int) -> bool:
    """Send SIGKILL to a process, which ends it in a LAPACK call, too; return whether it is still there."""
    try:
        os.kill(worker, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return not _is_zombie(worker)


def _is_zombie(worker: int) -> bool:
    """Return whether a process is dead, but its parent has not waited for it.

    It may stay so for ever: when its fork server was killed, too, and process 1, its new parent, does not wait for
    children, as in a container without an init.
    """
    with suppress(OSError):  # there is no /proc on macOS, whose process 1 waits for children
        return Path(f"/proc/{worker}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z"
    return False
