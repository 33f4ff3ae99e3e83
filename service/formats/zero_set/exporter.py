"""Zero sets of stored fits, drawn in a worker process."""

from dataclasses import dataclass

import numpy as np
import orjson

import ipcore
from service.formats.points import decode
from service.formats.zero_set.writers import WRITERS
from service.jobs.errors import InvalidInputError
from service.jobs.media_types import MeshRequest
from service.jobs.ports import Workers


@dataclass(frozen=True)
class MeshExporter:
    """The exporter that the use cases are given.

    Attributes
    ----------
    workers
        Where the work is done.
    deadline
        Seconds that one drawing may take.

    """

    workers: Workers
    deadline: float

    async def draw(self, result: bytes, points: bytes, dimension: int, drawing: MeshRequest) -> bytes:
        """Return a file with the zero set of a fit's result, given its point set."""
        content: bytes = await self.workers.run(draw, result, points, dimension, drawing, deadline=self.deadline)
        return content


def draw(result: bytes, points: bytes, dimension: int, drawing: MeshRequest) -> bytes:
    """Extract a zero set and write it as a file.

    Raises
    ------
    InvalidInputError
        If the zero set cannot be extracted in these bounds.

    """
    polynomial = ipcore.ImplicitPolynomial.from_dict(orjson.loads(result)["polynomial"])
    data, _ = decode.split(points, dimension)
    bounds = None if drawing.bounds is None else np.array(drawing.bounds)
    try:
        zero_set = ipcore.zero_set(polynomial, bounds, drawing.resolution, data=data, restrict=drawing.restrict)
    except ipcore.IPCoreError as error:
        raise InvalidInputError(error.message, error.at) from error
    return WRITERS[drawing.kind](zero_set)
