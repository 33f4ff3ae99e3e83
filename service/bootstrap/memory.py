"""How much memory each process may take, so that all of them together fit the machine or its container."""

import os
from contextlib import suppress
from pathlib import Path

# The share of the memory that the processes may take together; the rest is for the system and its file cache.
SHARE = 0.9
# What a worker gets, at least, however small the machine, and at most, however large.
LEAST, MOST = 512 * 2**20, 8 * 2**30
_CGROUPS = Path("/sys/fs/cgroup")
_OWN_CGROUP = Path("/proc/self/cgroup")


def worker_memory(processes: int, server: int) -> int:
    """Return the bytes that each of so many worker processes may take beside a server with `server` bytes."""
    share = (SHARE * available() - server) / processes
    return int(min(max(share, LEAST), MOST))


def available() -> int:
    """Return the bytes of memory of this machine, or of the control group in which this process runs, if less."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return min([machine, *_limits(_CGROUPS, _OWN_CGROUP)])


def _limits(root: Path, own: Path) -> list[int]:
    """Return the limits of this process's control groups and of those above them.

    Version 2 has one tree, with a line `0::/path`; in version 1 memory has a tree of its own: `4:memory:/path`. In a
    container the path may be that on the host, of which only the root is seen.
    """
    found = []
    with suppress(OSError):
        for line in own.read_text(encoding="ascii").splitlines():
            _, kinds, path = line.split(":", 2)
            if kinds not in {"", "memory"}:
                continue
            tree, name = (root, "memory.max") if not kinds else (root / "memory", "memory.limit_in_bytes")
            here = tree / path.lstrip("/")
            for folder in (here, *here.parents):
                found += _number(folder / name)
                if folder == tree:
                    break
    return found


def _number(file: Path) -> list[int]:
    """Return the limit in a file; none if there is none (`max`)."""
    with suppress(OSError, ValueError):
        return [int(file.read_text(encoding="ascii"))]
    return []
