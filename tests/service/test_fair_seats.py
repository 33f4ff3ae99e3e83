"""Seats for uploads and meshes: few at once, a bounded queue, and clients in turn."""

import asyncio
from collections.abc import Coroutine
from typing import Any

import pytest

from service.jobs.errors import QueueFullError
from service.workers.fair_seats import FairSeats


def run(script: Coroutine[Any, Any, None]) -> None:
    asyncio.run(script)


async def hold(seats: FairSeats, client: str, order: list[str], until: asyncio.Event | None = None) -> None:
    async with seats.taken(client):
        order.append(client)
        if until is not None:
            await until.wait()


async def begun(*tasks: asyncio.Task[None]) -> None:
    for _ in range(5 + len(tasks)):
        await asyncio.sleep(0)


def test_clients_take_turns_however_much_one_of_them_asks_for() -> None:
    async def script() -> None:
        seats, order, end = FairSeats("meshes", 1, 20, 60.0), list[str](), asyncio.Event()
        first = asyncio.create_task(hold(seats, "flood", order, end))
        await begun()
        flood = [asyncio.create_task(hold(seats, "flood", order)) for _ in range(5)]
        await begun(*flood)
        other = [asyncio.create_task(hold(seats, "other", order)) for _ in range(2)]
        await begun(*other)
        end.set()
        await asyncio.gather(first, *flood, *other)
        assert order == ["flood", "flood", "other", "flood", "other", "flood", "flood", "flood"]

    run(script())


def test_as_many_work_at_once_as_there_are_seats() -> None:
    async def script() -> None:
        seats, order, end = FairSeats("meshes", 2, 5, 60.0), list[str](), asyncio.Event()
        tasks = [asyncio.create_task(hold(seats, name, order, end)) for name in "abc"]
        await begun(*tasks)
        assert order == ["a", "b"]
        end.set()
        await asyncio.gather(*tasks)
        assert order == ["a", "b", "c"]

    run(script())


def test_who_finds_the_queue_full_is_told_when_to_come_back() -> None:
    async def script() -> None:
        seats, order, end = FairSeats("meshes", 1, 4, 60.0), list[str](), asyncio.Event()
        tasks = [asyncio.create_task(hold(seats, name, order, end)) for name in "abbcd"]
        await begun(*tasks)
        with pytest.raises(QueueFullError, match="4 meshes wait already") as full:
            await hold(seats, "e", order)
        assert full.value.retry_after == pytest.approx(5.0)  # four before it, of a second each as far as is known
        end.set()
        await asyncio.gather(*tasks)

    run(script())


def test_one_client_gets_half_of_the_places() -> None:
    async def script() -> None:
        seats, order, end = FairSeats("meshes", 1, 4, 60.0), list[str](), asyncio.Event()
        tasks = [asyncio.create_task(hold(seats, name, order, end)) for name in "aaa"]
        await begun(*tasks)
        with pytest.raises(QueueFullError, match="2 meshes of yours wait"):
            await hold(seats, "a", order)
        tasks.append(asyncio.create_task(hold(seats, "b", order, end)))
        await begun()
        end.set()
        await asyncio.gather(*tasks)
        assert order == ["a", "a", "b", "a"]

    run(script())


def test_a_place_is_given_up_by_who_leaves_or_has_waited_too_long() -> None:
    async def script() -> None:
        seats, order, end = FairSeats("meshes", 1, 4, 0.05), list[str](), asyncio.Event()
        first = asyncio.create_task(hold(seats, "a", order, end))
        await begun()
        left = asyncio.create_task(hold(seats, "b", order))
        await begun()
        left.cancel()
        with pytest.raises(QueueFullError, match="took too long to begin"):
            await hold(seats, "c", order)
        end.set()
        await asyncio.gather(first, left, return_exceptions=True)
        await hold(seats, "d", order)  # the seat is free again
        assert order == ["a", "d"]

    run(script())
