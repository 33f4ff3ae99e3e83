"""The memory of this process, from the system's books: nothing is asked of the allocator, so all of it counts."""

import resource
from pathlib import Path

STATUS, FORGET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
KIB = 1024
MB = 1e6


def forget() -> None:
    """Let the peak start again from what is resident now, where the system can (Linux)."""
    try:
        FORGET.write_text("5", encoding="ascii")
    except OSError:
        return


def peak() -> float:
    """Return the peak of the resident set, mapped files included, in MB.

    It is VmHWM where there is one: ru_maxrss of a new process starts at what its parent had.
    """
    try:
        lines = STATUS.read_text(encoding="ascii").splitlines()
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * KIB / MB
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * KIB / MB
