"""The memory of this process as the operating system counts it, whichever allocator took it."""

import resource
from pathlib import Path

STATUS, FORGET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
KIB = 1024
MB = 1e6


def forget() -> None:
    """Reset the peak to what is resident now. Only Linux can do this; elsewhere nothing happens."""
    try:
        FORGET.write_text("5", encoding="ascii")
    except OSError:
        return


def peak() -> float:
    """Return the peak of the resident set, mapped files included, in MB.

    On Linux it is VmHWM, because ru_maxrss of a new process starts at the value of its parent.
    """
    try:
        lines = STATUS.read_text(encoding="ascii").splitlines()
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * KIB / MB
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * KIB / MB
