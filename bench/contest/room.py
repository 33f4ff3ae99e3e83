"""The room that every contender gets: two cores, and some memory."""

import os
import resource

CORES = 2
DATA = 8_000_000_000  # bytes; a contender that asks for more fails, and not the machine


def enter() -> None:
    """Keep this process to its room."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:CORES])
    resource.setrlimit(resource.RLIMIT_DATA, (DATA, resource.getrlimit(resource.RLIMIT_DATA)[1]))


def surroundings() -> dict[str, str]:
    """Return the environment without what would tell a library how many threads to take: it decides by itself."""
    return {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
