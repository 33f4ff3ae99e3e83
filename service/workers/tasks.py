"""What runs inside a worker: a fit, from the stored point set to the answer's JSON; in parts, if it is a huge one."""

from collections.abc import Sequence
from dataclasses import asdict
from functools import reduce
from io import BytesIO
from operator import add
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

import ipcore
from service.jobs.errors import NotReadyError
from service.jobs.fit import PointSetRef
from service.jobs.ports import BlobStore
from service.jobs.slices import Slice
from service.workers.progress import report

# Bytes that hold the header of any npy of ours: numpy pads it to a multiple of 64, and 128 are enough for two axes.
HEADER = 256

Columns = tuple[NDArray[Any], NDArray[Any] | None]


def fit(blobs: BlobStore, given: PointSetRef, options: ipcore.FitOptions) -> bytes:
    """Fit a stored point set and return the answer as JSON; every degree is reported as it is made.

    Raises
    ------
    NotReadyError
        If the point set cannot be read, which is no fault of the fit.

    """
    points, normals = _halves(_table(blobs, given.key), given.dimension)
    return _json(ipcore.fit(points, normals, options, progress=_report))


def part(blobs: BlobStore, given: PointSetRef, options: ipcore.FitOptions, some: Slice) -> bytes:
    """Return the moments of some of the points, as a file.

    Raises
    ------
    NotReadyError
        As for `fit`.

    """
    dimension = given.dimension
    table = _rows(blobs, given.key, some.first, some.last)
    frame = ipcore.Frame(np.array(some.frame.centre), some.frame.scale)
    degree = _summed_degree(given, options)
    points, normals = table[:, :dimension], table[:, dimension:]
    moments = ipcore.Moments.of(points, normals, degree=degree, options=options, frame=frame)
    file = BytesIO()
    moments.without_sample().save(file)
    return file.getvalue()


def rest(blobs: BlobStore, given: PointSetRef, options: ipcore.FitOptions, sums: Sequence[bytes]) -> bytes:
    """Add the moments of all parts, in order, and fit; return and report as `fit` does.

    Raises
    ------
    NotReadyError
        As for `fit`.

    """
    points, normals = _halves(_table(blobs, given.key), given.dimension)
    moments = reduce(add, (ipcore.Moments.load(BytesIO(one)) for one in sums))
    return _json(moments.fit(options, points=points, normals=normals, progress=_report))


def _summed_degree(given: PointSetRef, options: ipcore.FitOptions) -> int:
    """Return the degree up to which moments are worth their time.

    Above it a fit goes over to the rows. One that is to go to the last degree asks for all moments at once.
    """
    plan = ipcore.plan(given.dimension, given.points, options, normals=True)
    return plan.max_degree if options.criterion is ipcore.Criterion.NONE else plan.moment_degree


def _report(step: ipcore.Step) -> None:
    report(asdict(step))


def _json(result: ipcore.FitResult) -> bytes:
    return orjson.dumps(result.to_dict())


def _halves(table: NDArray[Any], dimension: int) -> Columns:
    return table[:, :dimension], table[:, dimension:] if table.shape[1] > dimension else None


def _table(blobs: BlobStore, key: str) -> NDArray[Any]:
    table: NDArray[Any] = np.load(BytesIO(_read(blobs, key)), allow_pickle=False)
    return table


def _rows(blobs: BlobStore, key: str, first: int, last: int) -> NDArray[Any]:
    """Return some rows, without reading the others: every part of a huge set would read them all."""
    head = BytesIO(_read(blobs, key, 0, HEADER))
    np.lib.format.read_magic(head)
    shape, _, dtype = np.lib.format.read_array_header_1_0(head)
    start, row = head.tell(), shape[1] * dtype.itemsize
    content = _read(blobs, key, start + first * row, start + last * row)
    return np.frombuffer(content, dtype).reshape(last - first, shape[1])


def _read(blobs: BlobStore, key: str, start: int | None = None, end: int | None = None) -> bytes:
    try:
        return blobs.get(key, start, end)
    except Exception as error:  # whatever the file system raises, and not all of it can be pickled
        raise NotReadyError(f"the point set cannot be read: {type(error).__name__}: {error}") from error
