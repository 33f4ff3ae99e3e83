"""The cache of files: what is being sent stays, has its share, and gives room when it has been sent."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from pathlib import Path
from typing import Any

import pytest

from service.formats.file_cache import Details, FileCache
from service.jobs.errors import QueueFullError

Make = Callable[[Path], Awaitable[Details]]


def run(script: Coroutine[Any, Any, None]) -> None:
    asyncio.run(script)


def write(path: Path, size: int) -> None:
    path.write_bytes(b"x" * size)


def names(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir()]


def of(size: int) -> Make:
    """Return what makes a file of so many bytes."""

    async def make(path: Path) -> Details:
        write(path, size)
        return None, None

    return make


async def unwanted(path: Path) -> Details:
    raise AssertionError(f"{path} is made again")


def test_a_file_is_made_once_until_others_take_its_room(tmp_path: Path) -> None:
    async def script() -> None:
        cache = FileCache(tmp_path, 100)
        (await cache.get("a", of(60), "me")).release()
        (await cache.get("a", unwanted, "me")).release()
        (await cache.get("b", of(60), "me")).release()
        assert names(tmp_path) == ["b"]

    run(script())


def test_a_file_stays_while_it_is_sent(tmp_path: Path) -> None:
    async def script() -> None:
        cache = FileCache(tmp_path, 100)
        sent = [await cache.get("a", of(40), "me"), await cache.get("a", unwanted, "you")]
        (await cache.get("b", of(90), "you")).release()
        assert sent[0].path.read_bytes() == b"x" * 40
        sent[0].release()
        assert sent[1].path.exists()
        sent[1].release()
        (await cache.get("c", of(90), "me")).release()
        assert names(tmp_path) == ["c"]

    run(script())


def test_one_client_has_half_of_the_room_for_what_it_is_sent(tmp_path: Path) -> None:
    async def script() -> None:
        cache = FileCache(tmp_path, 100)
        slow = await cache.get("a", of(60), "slow")
        with pytest.raises(QueueFullError, match="60 bytes of files are being sent to you"):
            await cache.get("b", unwanted, "slow")
        (await cache.get("a", unwanted, "slow")).release()  # needs no more room
        other = await cache.get("c", of(45), "other")
        with pytest.raises(QueueFullError, match="all the room"):
            await cache.get("d", unwanted, "third")
        slow.release()
        (await cache.get("b", of(10), "slow")).release()
        other.release()

    run(script())


def test_nothing_is_left_of_a_file_that_could_not_be_made(tmp_path: Path) -> None:
    async def breaks_off(path: Path) -> Details:
        write(path, 1)
        raise OSError("no space left")

    async def script() -> None:
        cache = FileCache(tmp_path, 100)
        with pytest.raises(OSError, match="no space left"):
            await cache.get("a", breaks_off, "me")
        assert not names(tmp_path)
        (await cache.get("a", of(1), "me")).release()

    run(script())
