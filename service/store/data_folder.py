"""The data folder of one server: its places, and the lock that keeps it to one server at a time."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


class FolderInUseError(Exception):
    """Another server works in this folder: both would run the same fits."""


@dataclass(frozen=True)
class DataFolder:
    """Where one server keeps everything.

    Attributes
    ----------
    path
        The folder, absolute.

    """

    path: Path

    @property
    def database(self) -> Path:
        """Return the SQLite file of the fits."""
        return self.path / "fits.sqlite"

    @property
    def blobs(self) -> Path:
        """Return the folder of the point sets."""
        return self.path / "blobs"

    @property
    def incoming(self) -> Path:
        """Return the folder of large bodies while they are read."""
        return self.path / "incoming"


@contextmanager
def opened(path: Path) -> Iterator[DataFolder]:
    """Yield a data folder that is this server's alone, made if need be, and rid of a killed server's half-read bodies.

    Raises
    ------
    FolderInUseError
        If another server has it open.

    """
    folder = DataFolder(path.absolute())
    folder.incoming.mkdir(parents=True, exist_ok=True)
    with (folder.path / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # the system lets go of it when the process ends
        except BlockingIOError as error:
            raise FolderInUseError(
                f"another server uses {folder.path}; set IPFIT_DATA_DIR to another folder"
            ) from error
        for left in folder.incoming.iterdir():
            left.unlink()
        yield folder
