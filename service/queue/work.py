"""What is run for fits, and where; and the work on one fit, with the time that it took."""

import asyncio
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from service.jobs.ports import Workers


@dataclass(frozen=True)
class Tasks:
    """The functions that run in workers. Each takes the blobs, the fit's `PointSetRef` and its `ipcore.FitOptions`.

    Attributes
    ----------
    fit
        Fits all points at once.
    sum_moments
        Sums the moments of a slice of the points; takes the `Slice`, too.
    fit_from_moments
        Fits when the moments of all parts are summed; takes the results of the parts, too.

    """

    fit: Callable[..., bytes]
    sum_moments: Callable[..., bytes]
    fit_from_moments: Callable[..., bytes]


@dataclass(frozen=True)
class Lanes:
    """The workers of each lane of the queue; those for short fits alone may have a higher priority.

    Attributes
    ----------
    any_length, short
        The workers of the lane of all fits, and of the lane of short fits.

    """

    any_length: Workers
    short: Workers


class Work:
    """The work on one fit or part, which begins at once."""

    def __init__(self, work: Coroutine[Any, Any, bytes]) -> None:
        """Begin it."""
        self._began, self._ended = time.monotonic(), 0.0
        self.task = asyncio.create_task(work)
        self.task.add_done_callback(self._end)

    def _end(self, _: asyncio.Task[bytes]) -> None:
        self._ended = time.monotonic()

    @property
    def seconds(self) -> float:
        """Return how long it took, or has taken so far."""
        return (self._ended or time.monotonic()) - self._began

    async def cancelled(self) -> None:
        """Cancel it, and return when it has ended."""
        self.task.cancel()
        await asyncio.gather(self.task, return_exceptions=True)
