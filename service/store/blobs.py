"""Content-addressed blobs on any fsspec file system."""

import hashlib
import os
import re
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any
from uuid import uuid4

import fsspec

# Protocols under which an object appears whole or not at all when it is put, and renaming would copy it.
OBJECT_STORES = {"s3", "s3a", "gs", "gcs", "abfs", "abfss", "az"}
# Seconds after which a partly written blob is taken to be abandoned: the process that wrote it is dead.
ABANDONED_SECONDS = 3600.0
_KEY = re.compile("[0-9a-f]{64}")


@dataclass(frozen=True)
class Blobs:
    """Blobs in a folder, each under the SHA-256 of its content, in subfolders named after its first two digits.

    Attributes
    ----------
    url
        The folder: a path, or any URL that fsspec knows.
    patience
        Seconds that an object store may take for one answer; its own timeout is minutes.

    """

    url: str
    patience: float = 20.0

    def put(self, content: bytes, key: str | None = None) -> str:
        """Store bytes whole and return their key; `key` is their SHA-256, if it is known."""
        key = key or hashlib.sha256(content).hexdigest()
        fs, path = self._at(key)
        if not fs.exists(path, **self._limits(fs)):
            if OBJECT_STORES.intersection(_protocols(fs)):
                fs.pipe_file(path, content, **self._limits(fs))
            else:
                _write_and_rename(fs, path, content)
        if "file" in _protocols(fs):  # a file survives a crash when the entries of its folders are flushed, too
            for folder in (Path(path).parent, Path(path).parent.parent):
                _flush(folder)
        return key

    def get(self, key: str, start: int | None = None, end: int | None = None) -> bytes:
        """Return the bytes stored under a key, or those from `start` to before `end`."""
        fs, path = self._at(key)
        return bytes(fs.cat_file(path, start=start, end=end, **self._limits(fs)))

    def delete(self, key: str) -> None:
        """Remove the bytes under a key, if there are any."""
        fs, path = self._at(key)
        with suppress(FileNotFoundError):
            fs.rm_file(path, **self._limits(fs))

    def keys(self) -> list[str]:
        """Return the key of every blob; remove partly written ones that were abandoned."""
        fs, root = self._root()
        found = []
        for path in fs.find(root):
            key, _, suffix = path.rpartition("/")[2].partition(".")
            if not _KEY.fullmatch(key):  # no blob
                continue
            if not suffix:
                found.append(key)
            elif fs.modified(path) < datetime.now(UTC) - timedelta(seconds=ABANDONED_SECONDS):
                with suppress(FileNotFoundError):
                    fs.rm_file(path)
        return found

    def _root(self) -> tuple[fsspec.AbstractFileSystem, str]:
        found: tuple[fsspec.AbstractFileSystem, str] = fsspec.url_to_fs(
            self.url,
            use_listings_cache=False,  # other processes put and delete here, too
        )
        return found

    def _at(self, key: str) -> tuple[fsspec.AbstractFileSystem, str]:
        fs, root = self._root()
        return fs, f"{root}/{key[:2]}/{key}"

    def _limits(self, fs: fsspec.AbstractFileSystem) -> dict[str, Any]:
        """Return the timeout of a call, for file systems that work on fsspec's event loop: no others take one."""
        return {"timeout": self.patience} if fs.async_impl else {}


def _protocols(fs: fsspec.AbstractFileSystem) -> tuple[str, ...]:
    return (fs.protocol,) if isinstance(fs.protocol, str) else tuple(fs.protocol)


def _write_and_rename(fs: fsspec.AbstractFileSystem, path: str, content: bytes) -> None:
    """Write a file under another name, flush it and rename it; if that fails, leave nothing."""
    fs.makedirs(fs._parent(path), exist_ok=True)  # noqa: SLF001 - fsspec's documented way to a parent path
    temporary = f"{path}.{uuid4().hex}"
    try:
        with fs.open(temporary, "wb") as file:
            file.write(content)
            file.flush()
            if "file" in _protocols(fs):
                os.fsync(file.fileno())
        fs.mv(temporary, path)
    except BaseException:
        with suppress(Exception):
            fs.rm_file(temporary)
        raise


def _flush(folder: Path) -> None:
    """Flush the list of a folder's entries to disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
