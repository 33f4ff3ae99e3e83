"""The data folder of one server: its files, and the lock that lets one server at a time use it."""

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path


class FolderInUseError(Exception):
    """Another server uses this folder: both would run the same fits."""


class FolderDeniedError(Exception):
    """The user of this process may not write to this folder."""


@dataclass(frozen=True)
class DataFolder:
    """The folder in which one server stores everything.

    Attributes
    ----------
    path
        The folder, absolute.

    """

    path: Path

    @property
    def database(self) -> Path:
        """Return the path of the SQLite file with the fits."""
        return self.path / "fits.sqlite"

    @property
    def blobs(self) -> Path:
        """Return the path of the folder with the point sets."""
        return self.path / "blobs"

    @property
    def files(self) -> Path:
        """Return the path of the folder with the meshes and other files that were made."""
        return self.path / "files"

    @property
    def incoming(self) -> Path:
        """Return the path of the folder with the bodies of requests that are being read."""
        return self.path / "incoming"


@contextmanager
def opened(path: Path) -> Iterator[DataFolder]:
    """Yield the data folder, made if need be and locked for this server; delete bodies that a killed server left.

    Raises
    ------
    FolderDeniedError
        If this user may not write to it, or to what is in it.
    FolderInUseError
        If another server has it open.

    """
    folder = DataFolder(path.absolute())
    with ExitStack() as stack:
        try:
            _make(folder)
            lock = stack.enter_context((folder.path / "lock").open("w"))
        except OSError as error:
            if error.errno in {errno.ENOSPC, errno.EDQUOT, errno.EIO}:  # of the disk, and not of the folder
                raise
            user = f"user {os.geteuid()} of group {os.getegid()}"
            raise FolderDeniedError(
                f"{error.filename} cannot be written by {user} ({error.strerror}); "
                "set IPFIT_DATA_DIR to a folder that can"
            ) from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # the system releases it when the process ends
        except BlockingIOError as error:
            raise FolderInUseError(
                f"another server uses {folder.path}; set IPFIT_DATA_DIR to another folder"
            ) from error
        for left in (*folder.incoming.iterdir(), *folder.files.iterdir()):
            left.unlink()
        yield folder


def _make(folder: DataFolder) -> None:
    """Make the folder and those in it, for the user of this process alone."""
    for one in (folder.path, folder.incoming, folder.files):
        one.mkdir(parents=True, exist_ok=True, mode=0o700)
    with suppress(PermissionError):  # another user made it for this one, as for a volume of a container
        folder.path.chmod(folder.path.stat().st_mode & 0o770)
