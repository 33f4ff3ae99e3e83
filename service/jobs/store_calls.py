"""Calling a store, which blocks, from the event loop, which must not."""

import asyncio
from collections.abc import Callable
from typing import TypeVar

from service.jobs.errors import JobError, NotReadyError

T = TypeVar("T")


async def call_store(call: Callable[..., T], *arguments: object) -> T:
    """Call a store in a thread. An error there, such as a full disk or a lost database, is one that may pass.

    Raises
    ------
    NotReadyError
        In its place.

    """
    try:
        return await asyncio.to_thread(call, *arguments)
    except JobError:
        raise
    except Exception as error:
        raise NotReadyError(f"fits cannot be stored or looked up at the moment: {type(error).__name__}") from error
