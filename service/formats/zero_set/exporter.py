"""Files of the zero sets of stored fits, made in a worker process."""

from dataclasses import dataclass

import numpy as np
import orjson

import ipcore
from service.formats.points import decode
from service.formats.zero_set.writers import WRITERS
from service.jobs.errors import InvalidInputError
from service.jobs.mesh_request import MeshRequest
from service.jobs.ports import Workers
from service.jobs.zero_set_file import ZeroSetFile


@dataclass(frozen=True)
class MeshExporter:
    """The exporter that the use cases are given.

    Attributes
    ----------
    workers
        Where the work is done.
    deadline
        Seconds that one export may take.

    """

    workers: Workers
    deadline: float

    async def export(self, result: bytes, points: bytes, dimension: int, wanted: MeshRequest) -> ZeroSetFile:
        """Return the file of the zero set of a fit, from its result as JSON and its point set as npy."""
        return await self.workers.run(export, result, points, dimension, wanted, deadline=self.deadline)


def export(result: bytes, points: bytes, dimension: int, wanted: MeshRequest) -> ZeroSetFile:
    """Extract a zero set and write it as a file.

    Raises
    ------
    InvalidInputError
        If the zero set cannot be extracted in these bounds.

    """
    polynomial = ipcore.ImplicitPolynomial.from_dict(orjson.loads(result)["polynomial"])
    data, _ = decode.split(points, dimension)
    bounds = None if wanted.bounds is None else np.array(wanted.bounds)
    try:
        zero_set = ipcore.zero_set(polynomial, bounds, wanted.resolution, data=data, restrict=wanted.restrict)
    except ipcore.IPCoreError as error:
        raise InvalidInputError(error.message, error.at) from error
    return ZeroSetFile(WRITERS[wanted.format](zero_set), zero_set.warning)
