"""Reading point sets off the event loop: a small body in a thread, a large one in a worker process."""

import asyncio
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from service.formats.points import decode, write
from service.jobs.fit import ReceivedPoints
from service.jobs.media_types import Missing
from service.jobs.ports import Workers


@dataclass(frozen=True)
class PointSetReader:
    """The reader that the use cases are given.

    Attributes
    ----------
    workers
        Where large bodies are read.
    max_points
        More are refused.
    deadline
        Seconds that reading one may take.

    """

    workers: Workers
    max_points: int
    deadline: float

    async def read(
        self, body: bytes | Path, kind: str, *, columns: str | None = None, missing: Missing = "refuse"
    ) -> ReceivedPoints:
        """Read and check a body of this kind; see `decode.read`."""
        read = partial(decode.read, body, kind, self.max_points, columns=columns, missing=missing)
        if isinstance(body, bytes):
            return await asyncio.to_thread(read)
        points: ReceivedPoints = await self.workers.run(read, deadline=self.deadline)
        return points

    async def write(self, content: bytes, dimension: int, form: str) -> bytes:
        """Return a stored point set as a file of the format `form`; see `write.write`."""
        if form == "npy":
            return content
        written: bytes = await self.workers.run(write.write, content, dimension, form, deadline=self.deadline)
        return written
