"""Reading point sets off the event loop: a small body in a thread, a large one in a worker process."""

import asyncio
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from service.formats.points import decode
from service.jobs.fit import ReceivedPoints
from service.jobs.media_types import Missing
from service.jobs.ports import Seats, Workers


@dataclass(frozen=True)
class PointSetReader:
    """The reader that the use cases are given.

    Attributes
    ----------
    workers, seats
        Where large bodies are read, and for how many at once.
    max_points
        More are refused.
    deadline
        Seconds that reading one may take.

    """

    workers: Workers
    seats: Seats
    max_points: int
    deadline: float

    async def read(
        self,
        body: bytes | Path,
        kind: str,
        *,
        columns: str | None = None,
        missing: Missing = "refuse",
        client: str = "",
    ) -> ReceivedPoints:
        """Read and check a body of this kind; see `decode.read`."""
        read = partial(decode.read, body, kind, self.max_points, columns=columns, missing=missing)
        if isinstance(body, bytes):
            return await asyncio.to_thread(read)
        async with self.seats.taken(client):
            points: ReceivedPoints = await self.workers.run(read, deadline=self.deadline)
        return points
