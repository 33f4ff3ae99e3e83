"""A cache of files on disk: those that were used last, up to a number of bytes."""

import asyncio
import os
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from pathlib import Path
from weakref import WeakValueDictionary

from service.jobs.exported_file import ExportedFile

Details = tuple[str | None, str | None]  # the encoding and the warning of an ExportedFile


class FileCache:
    """Files in a folder, each made once for all who ask for it at the same time or later."""

    def __init__(self, folder: Path, most_bytes: int) -> None:
        """Keep at most so many bytes in a folder, which is empty; the file used last stays in any case."""
        self._folder, self._most, self._bytes = folder, most_bytes, 0
        self._files: OrderedDict[str, tuple[int, ExportedFile]] = OrderedDict()
        self._locks: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    async def get(self, name: str, make: Callable[[Path], Awaitable[Details]]) -> ExportedFile:
        """Return the file of this name; `make` writes it to a path if it is not there.

        If the caller for whom it is being made goes away, it is made for the next who waits for it.
        """
        lock = self._locks.setdefault(name, asyncio.Lock())
        async with lock:
            if name in self._files:
                self._files.move_to_end(name)
                return self._files[name][1]
            return await self._made(name, make)

    async def _made(self, name: str, make: Callable[[Path], Awaitable[Details]]) -> ExportedFile:
        path, part = self._folder / name, self._folder / f"{name}.part"
        try:
            encoding, warning = await make(part)
            size = part.stat().st_size
            os.replace(part, path)  # noqa: PTH105 - one name for both systems, and as quick as the calls around it
        finally:
            part.unlink(missing_ok=True)
        file = ExportedFile(path, encoding, warning)
        self._files[name] = size, file
        self._bytes += size
        while self._bytes > self._most and len(self._files) > 1:
            _, (freed, oldest) = self._files.popitem(last=False)
            oldest.path.unlink(missing_ok=True)
            self._bytes -= freed
        return file
