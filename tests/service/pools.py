"""A pool of workers to try, and tasks for it."""

import asyncio
import os
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from typing import Any

from service.workers.pool import WorkerPool

Script = Callable[[WorkerPool], Coroutine[Any, Any, None]]


def pid() -> int:
    return os.getpid()


def sleep(seconds: float) -> int:
    time.sleep(seconds)
    return os.getpid()


@asynccontextmanager
async def pool(size: int = 1, tasks: int = 100) -> AsyncIterator[WorkerPool]:
    made = WorkerPool(size, tasks, 2**30)
    try:
        yield made
    finally:
        await asyncio.to_thread(made.close)


def run(script: Script, size: int = 1, tasks: int = 100) -> None:
    async def whole() -> None:
        async with pool(size, tasks) as workers:
            await script(workers)

    asyncio.run(whole())
