"""A cache of files on disk: those that were used last, up to a number of bytes."""

import asyncio
import os
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from weakref import WeakValueDictionary

from service.jobs.errors import QueueFullError
from service.jobs.exported_file import ExportedFile

Details = tuple[str | None, str | None]  # the encoding and the warning of an ExportedFile

ROOM_SECONDS = 10.0  # after which there may be room, when files that are being sent take all of it


@dataclass
class _Kept:
    """A file of the cache.

    Attributes
    ----------
    file, size
        The file and its bytes.
    readers
        How many are reading it. It stays until there are none.

    """

    file: ExportedFile
    size: int
    readers: int = 0


class FileCache:
    """Files in a folder, each made once for all who ask for it at the same time or later."""

    def __init__(self, folder: Path, most_bytes: int) -> None:
        """Keep about so many bytes in a folder, which is empty: one file more at most for each that is being made."""
        self._folder, self._most, self._bytes = folder, most_bytes, 0
        self._files: OrderedDict[str, _Kept] = OrderedDict()  # in the order of their last use
        self._locks: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    async def get(self, name: str, make: Callable[[Path], Awaitable[Details]]) -> ExportedFile:
        """Return the file of this name, to be released by its reader; `make` writes it to a path if it is not there.

        If the caller for whom it is being made goes away, it is made for the next who waits for it.

        Raises
        ------
        QueueFullError
            If files that are being read take all the room.

        """
        lock = self._locks.setdefault(name, asyncio.Lock())
        async with lock:
            if name not in self._files:
                self._check_room()
                await self._make(name, make)
            kept = self._files[name]
            self._files.move_to_end(name)
            kept.readers += 1
            self._evict()
            return kept.file

    def _check_room(self) -> None:
        """Refuse to make a file while those that cannot be removed take all the room."""
        if sum(kept.size for kept in self._files.values() if kept.readers) >= self._most:
            raise QueueFullError("files that are being sent take all the room for files", ROOM_SECONDS)

    async def _make(self, name: str, make: Callable[[Path], Awaitable[Details]]) -> None:
        path, part = self._folder / name, self._folder / f"{name}.part"
        try:
            encoding, warning = await make(part)
            size = part.stat().st_size
            os.replace(part, path)  # noqa: PTH105 - one name for both systems, and as quick as the calls around it
        finally:
            part.unlink(missing_ok=True)
        file = ExportedFile(path, partial(self._release, name), encoding, warning)
        self._files[name] = _Kept(file, size)
        self._bytes += size

    def _release(self, name: str) -> None:
        """Note that a reader of a file has ended."""
        self._files[name].readers -= 1
        self._evict()

    def _evict(self) -> None:
        """Remove the files that were not used for longest and that nobody reads, until the others fit."""
        for name, kept in list(self._files.items()):
            if self._bytes <= self._most:
                return
            if not kept.readers:
                del self._files[name]
                self._bytes -= kept.size
                kept.file.path.unlink(missing_ok=True)
