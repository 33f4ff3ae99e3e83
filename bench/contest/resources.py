"""The resources of every contender: two cores and a limited amount of memory."""

import os
import resource

CORES = 2
MEMORY = 8_000_000_000  # bytes; a contender that needs more fails, before the machine runs out


def limit() -> None:
    """Restrict this process to the first cores and the memory above."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:CORES])
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, resource.getrlimit(resource.RLIMIT_DATA)[1]))


def environment() -> dict[str, str]:
    """Return the environment without variables that set a number of threads, so that each library chooses its own."""
    return {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
