"""Temporary folders that do not outlive the process that made them: what a killed one left, the next one removes."""

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO

# Neither name is one of a data folder, which must never be taken for a folder that was left.
FOLDER_PREFIX = "ipfit-temporary-"
_LOCK = ".in-use"  # held by the process that uses the folder; the system releases it when the process ends


class TemporaryFolder:
    """A folder for this process alone, with the right to enter it for its user only."""

    def __init__(self) -> None:
        """Make the folder, and remove those that dead processes of the same user left."""
        _sweep(Path(tempfile.gettempdir()))
        self.path, self._lock = _locked_folder()

    def remove(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self.path, ignore_errors=True)
        self._lock.close()


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield the path of a temporary folder, which is removed afterwards."""
    folder = TemporaryFolder()
    try:
        yield folder.path
    finally:
        folder.remove()


def _locked_folder() -> tuple[Path, IO[str]]:
    """Return a new folder and its lock, which is held."""
    while True:
        path = Path(tempfile.mkdtemp(prefix=FOLDER_PREFIX))
        lock = (path / _LOCK).open("w")
        fcntl.flock(lock, fcntl.LOCK_EX)
        if (path / _LOCK).exists():
            return path, lock
        lock.close()  # another process that starts took the folder for one that was left, before it was locked


def _sweep(where: Path) -> None:
    """Remove the temporary folders whose processes have ended. One without a lock is being made at this moment."""
    for folder in where.glob(f"{FOLDER_PREFIX}*"):
        with suppress(OSError), ExitStack() as stack:
            if folder.is_symlink() or folder.stat().st_uid != os.getuid():
                continue
            lock: IO[str] = stack.enter_context((folder / _LOCK).open("r+"))
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
