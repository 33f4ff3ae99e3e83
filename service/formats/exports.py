"""Files of stored fits: zero sets and points, made in worker processes and kept in a cache."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import orjson

import ipcore
from service.compression import compressed
from service.formats.file_cache import Details, FileCache
from service.formats.points import decode, write
from service.formats.zero_set.size import check_size
from service.formats.zero_set.writers import WRITERS
from service.jobs.errors import InvalidInputError, NotReadyError
from service.jobs.exported_file import ExportedFile
from service.jobs.fit import PointSetRef
from service.jobs.mesh_request import MeshRequest
from service.jobs.ports import Seats, Workers
from service.jobs.store_ports import BlobStore


@dataclass(frozen=True)
class Exports:
    """The exports that the use cases are given.

    Attributes
    ----------
    workers, seats
        Where files are made, and for how many at once.
    cache
        The files that were made.
    blobs
        The point sets, which the workers read.
    deadline
        Seconds that making one may take.
    most_bytes
        Bytes of the largest file, before it is compressed.

    """

    workers: Workers
    seats: Seats
    cache: FileCache
    blobs: BlobStore
    deadline: float
    most_bytes: int

    def zero_set_name(self, result: bytes, points: PointSetRef, wanted: MeshRequest) -> str:
        """Return the name of the file of a zero set: the same for the same polynomial, request and version."""
        return _name(orjson.loads(result)["polynomial"], points.key, wanted, version("ipfit"))

    async def zero_set(
        self, result: bytes, points: PointSetRef, wanted: MeshRequest, encoding: str | None, client: str
    ) -> ExportedFile:
        """Return the file of the zero set of a fit, from its result as JSON, compressed if `encoding` is given."""
        name = f"{self.zero_set_name(result, points, wanted)}.{encoding}"
        return await self._file(
            name, client, export_zero_set, result, self.blobs, points, wanted, self.most_bytes, encoding
        )

    async def points(self, points: PointSetRef, form: str, encoding: str | None, client: str) -> ExportedFile:
        """Return a point set as a file of the format `form`, compressed if `encoding` is given."""
        return await self._file(
            f"{_name(points.key, form)}.{encoding}", client, export_points, self.blobs, points, form, encoding
        )

    async def _file(self, name: str, client: str, function: Callable[..., Details], *arguments: Any) -> ExportedFile:  # noqa: ANN401 - what the function takes
        async def make(path: Path) -> Details:
            async with self.seats.taken(client):
                return await self.workers.run(function, path, *arguments, deadline=self.deadline)

        return await self.cache.get(name, make, client)


def export_zero_set(  # noqa: PLR0913, PLR0917 - what to make of what, and how
    path: Path,
    result: bytes,
    blobs: BlobStore,
    points: PointSetRef,
    wanted: MeshRequest,
    most_bytes: int,
    encoding: str | None,
) -> Details:
    """Extract a zero set and write it to a file.

    Raises
    ------
    InvalidInputError
        If the zero set cannot be extracted in these bounds.
    TooLargeError
        If the file would be larger than `most_bytes`.
    NotReadyError
        If the points cannot be read, or the file cannot be written.

    """
    polynomial = ipcore.ImplicitPolynomial.from_dict(orjson.loads(result)["polynomial"])
    data, _ = decode.split(_stored(blobs, points), points.dimension)
    bounds = None if wanted.bounds is None else np.array(wanted.bounds)

    def extracted(resolution: int | None) -> ipcore.ZeroSet:
        return ipcore.zero_set(polynomial, bounds, resolution, data=data, restrict=wanted.restrict)

    try:
        check_size(extracted, WRITERS[wanted.format], wanted.resolution, points.dimension, most_bytes)
        zero_set = extracted(wanted.resolution)
    except ipcore.IPCoreError as error:
        raise InvalidInputError(error.message, error.at) from error
    return _written(path, WRITERS[wanted.format](zero_set), encoding), zero_set.warning


def export_points(path: Path, blobs: BlobStore, points: PointSetRef, form: str, encoding: str | None) -> Details:
    """Write a stored point set to a file of the format `form`.

    Raises
    ------
    NotReadyError
        If the points cannot be read, or the file cannot be written.

    """
    return _written(path, write.write(_stored(blobs, points), points.dimension, form), encoding), None


def _name(*parts: object) -> str:
    text = orjson.dumps(parts, option=orjson.OPT_SORT_KEYS)
    return hashlib.sha256(text).hexdigest()[:32]


def _stored(blobs: BlobStore, points: PointSetRef) -> bytes:
    try:
        return blobs.get(points.key)
    except Exception as error:  # noqa: BLE001 - the errors of file systems differ, and not all can be pickled
        raise NotReadyError(f"the point set cannot be read: {type(error).__name__}") from None


def _written(path: Path, content: bytes, encoding: str | None) -> str | None:
    """Write a file, compressed where that pays; return how it is compressed."""
    data, used = compressed(content, encoding)
    try:
        path.write_bytes(data)
    except OSError as error:
        raise NotReadyError(f"a file cannot be made: {error.strerror}") from None
    return used
