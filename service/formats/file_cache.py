"""A cache of files on disk: those that were used last, up to a number of bytes."""

import asyncio
import os
from collections import Counter, OrderedDict
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from weakref import WeakValueDictionary

from service.jobs.errors import QueueFullError
from service.jobs.exported_file import ExportedFile

Details = tuple[str | None, str | None]  # the encoding and the warning of an ExportedFile

ROOM_SECONDS = 10.0  # after which there may be room, when files that are being sent take all of it
# The share of the bytes that one client may be sent at once: one that reads slowly must not keep the files of others.
SHARE_SENT_TO_A_CLIENT = 0.5


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
        """Keep about so many bytes in a folder, which is empty, and besides what is being made or sent."""
        self._folder, self._most, self._bytes = folder, most_bytes, 0
        self._files: OrderedDict[str, _Kept] = OrderedDict()  # in the order of their last use
        self._sent: Counter[str] = Counter()  # bytes of the files that are being sent, by client
        self._locks: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    async def get(self, name: str, make: Callable[[Path], Awaitable[Details]], client: str) -> ExportedFile:
        """Return the file of this name, to be released by its reader; `make` writes it to a path if it is not there.

        If the caller for whom it is being made goes away, it is made for the next who waits for it.

        Raises
        ------
        QueueFullError
            If files that are being sent take all the room, or those of this client its share.

        """
        lock = self._locks.setdefault(name, asyncio.Lock())
        async with lock:
            if name not in self._files:
                self._check_room(client)
                await self._make(name, make)
            kept = self._files[name]
            self._files.move_to_end(name)
            kept.readers += 1
            self._sent[client] += kept.size
            self._evict()
            return replace(kept.file, release=partial(self._release, name, client))

    def _check_room(self, client: str) -> None:
        """Refuse to make a file while those that cannot be removed take all the room, or this client's part of it."""
        if self._sent[client] >= SHARE_SENT_TO_A_CLIENT * self._most:
            raise QueueFullError(f"{self._sent[client]} bytes of files are being sent to you", ROOM_SECONDS)
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
        self._files[name] = _Kept(ExportedFile(path, _nothing, encoding, warning), size)
        self._bytes += size

    def _release(self, name: str, client: str) -> None:
        """Note that a reader of a file has ended."""
        kept = self._files[name]
        kept.readers -= 1
        self._sent[client] -= kept.size
        if self._sent[client] <= 0:
            del self._sent[client]
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


def _nothing() -> None:
    """Release a file of the cache itself, which no reader has."""
