"""Reading point sets off the event loop: a small body in a thread, a large one in a worker process."""

import asyncio
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from service.formats.points import decode
from service.jobs.fit import ReceivedPoints
from service.jobs.ports import Seats, Workers
from service.jobs.read_request import ReadRequest


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

    async def read(self, body: bytes | Path, asked: ReadRequest) -> ReceivedPoints:
        """Read and check a body; see `decode.read`."""
        read = partial(decode.read, body, asked.kind, self.max_points, columns=asked.columns, missing=asked.missing)
        if isinstance(body, bytes):
            return await asyncio.to_thread(read)
        async with self.seats.taken(asked.client):
            points: ReceivedPoints = await self.workers.run(read, deadline=self.deadline)
        return points
