"""A seat: a pebble pool of one process, and running a task in it."""

import asyncio
from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any, TypeVar

from pebble import ProcessFuture, ProcessPool

from service.workers import worker_side

# Seconds between two checks that the pool of a running task is alive.
POOL_CHECK_SECONDS = 1.0

T = TypeVar("T")


def scheduled(
    seat: ProcessPool, task: str, function: Callable[..., T], arguments: tuple[object, ...]
) -> ProcessFuture[T]:
    """Schedule a function in a seat, as this task.

    Raises
    ------
    BrokenProcessPool
        If its pool has ended.

    """
    try:
        return seat.schedule(worker_side.run, args=(task, function, arguments))
    except RuntimeError as error:
        raise BrokenProcessPool(str(error)) from error


async def outcome(seat: ProcessPool, future: ProcessFuture[T]) -> T:
    """Return the result of a task, or raise if its pool ends before; when cancelled, cancel the task."""
    answer = asyncio.wrap_future(future)
    try:
        while not (await asyncio.wait((answer,), timeout=POOL_CHECK_SECONDS))[0]:
            if not seat.active and not answer.done():
                raise BrokenProcessPool("the pool ended before its task")
        return answer.result()
    finally:
        answer.cancel()


def in_loop(loop: asyncio.AbstractEventLoop, listener: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a function that another thread may call, and that calls the listener in the event loop."""

    def pass_on(payload: object) -> None:
        with suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(listener, payload)

    return pass_on
