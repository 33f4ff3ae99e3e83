"""Content-addressed bytes on any fsspec file system."""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

import fsspec


@dataclass(frozen=True)
class Blobs:
    """Bytes in a folder, each under the SHA-256 of its content, two levels deep.

    Attributes
    ----------
    url
        The folder: a path, or any URL that fsspec knows.

    """

    url: str

    def put(self, content: bytes) -> str:
        """Store bytes and return their key: written aside, flushed and renamed, so a key never names half a blob."""
        key = hashlib.sha256(content).hexdigest()
        fs, path = self._at(key)
        if fs.exists(path):
            return key
        fs.makedirs(fs._parent(path), exist_ok=True)  # noqa: SLF001 - fsspec's documented way to a parent path
        aside = f"{path}.{uuid4().hex}"
        with fs.open(aside, "wb") as file:
            file.write(content)
            file.flush()
            if "file" in fs.protocol:
                os.fsync(file.fileno())
        fs.mv(aside, path)
        if "file" in fs.protocol:  # the names are on disk, too, when the folders that hold them are
            for folder in (Path(path).parent, Path(path).parent.parent):
                _flush(folder)
        return key

    def get(self, key: str) -> bytes:
        """Return the bytes stored under a key."""
        fs, path = self._at(key)
        return bytes(fs.cat_file(path))

    def delete(self, key: str) -> None:
        """Remove the bytes under a key, if they are there."""
        fs, path = self._at(key)
        if fs.exists(path):
            fs.rm_file(path)

    def _at(self, key: str) -> tuple[fsspec.AbstractFileSystem, str]:
        fs, root = fsspec.url_to_fs(self.url, use_listings_cache=False)  # others put and delete here, too
        return fs, f"{root}/{key[:2]}/{key}"


def _flush(folder: Path) -> None:
    """Write a folder's list of names to disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
