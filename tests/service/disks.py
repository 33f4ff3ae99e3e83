"""Full disks: a file system of a few megabytes in memory, which only root may mount."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


class Disk:
    """A small disk, and a file that can fill it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._ballast = folder / "ballast"

    def fill(self) -> None:
        """Fill the disk."""
        with self._ballast.open("ab") as file:
            while room := self.room:
                os.posix_fallocate(file.fileno(), os.fstat(file.fileno()).st_size, room)

    def clear(self) -> None:
        """Remove the file that fills the disk."""
        self._ballast.unlink(missing_ok=True)

    @property
    def room(self) -> int:
        found = os.statvfs(self.folder)
        return found.f_bavail * found.f_bsize


@contextmanager
def small(megabytes: int) -> Iterator[Disk]:
    """Yield a disk of so many megabytes; skip the test where that is not allowed."""
    if os.geteuid() != 0:
        pytest.skip("A REALLY FULL DISK WAS NOT TESTED: only root may mount one")
    if shutil.which("mount") is None:
        pytest.skip("A REALLY FULL DISK WAS NOT TESTED: there is no mount command here")
    place = Path(tempfile.mkdtemp(prefix="ipfit-disk-"))
    place.chmod(0o755)  # PostgreSQL runs as another user and needs access, too
    folder = place / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={megabytes}m,mode=777", "ipfit-test", str(folder)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)  # noqa: S603 - our own folder
    if done.returncode != 0:
        pytest.skip(f"A REALLY FULL DISK WAS NOT TESTED: {done.stderr.strip()}")
    try:
        yield Disk(folder)
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)  # noqa: S603, S607 - as above
        shutil.rmtree(place)
