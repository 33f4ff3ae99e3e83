"""The tasks that run in workers: from a stored point set to the result of its fit, as a whole or in parts."""

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
from service.jobs.slices import Slice
from service.jobs.store_ports import BlobStore
from service.workers.progress import report

# Bytes that contain the whole header of a stored npy: numpy pads it to a multiple of 64, and two axes take 128.
HEADER_BYTES = 256
# Points of the circle that shows whether this process can fit, and how far off its fit may be, in radii: by its layers
# inside and outside, the linear fit is 0.0008 off.
CIRCLE_POINTS, CIRCLE_TOLERANCE = 24, 0.002


def fit(blobs: BlobStore, given: PointSetRef, options: ipcore.FitOptions) -> bytes:
    """Fit a stored point set and return the result as JSON; report every degree when it has been tried.

    Raises
    ------
    NotReadyError
        If the point set cannot be read; the fit is then tried again later.

    """
    return _json(ipcore.fit(_point_set(blobs, given), options=options, progress=_report))


def sum_moments(blobs: BlobStore, given: PointSetRef, options: ipcore.FitOptions, some: Slice) -> bytes:
    """Return the moments of a slice of the points, as an npz file.

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


def fit_from_moments(blobs: BlobStore, given: PointSetRef, options: ipcore.FitOptions, sums: Sequence[bytes]) -> bytes:
    """Add the moments of all slices, in their order, and fit; return and report as `fit` does.

    Raises
    ------
    NotReadyError
        As for `fit`.

    """
    moments = reduce(add, (ipcore.Moments.load(BytesIO(one)) for one in sums))
    return _json(moments.fit(options, points=_point_set(blobs, given), progress=_report))


def fit_circle() -> None:
    """Fit a circle, in some hundredths of a second.

    Raises
    ------
    ArithmeticError
        If what comes out is no circle.

    """
    angle = np.linspace(0.0, 2.0 * np.pi, CIRCLE_POINTS, endpoint=False)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    result = ipcore.fit(points, points, options=ipcore.FitOptions(geometric=False, max_degree=2))
    if not result.diagnostics.d_dist < CIRCLE_TOLERANCE:
        raise ArithmeticError(f"the fit of a circle is {result.diagnostics.d_dist:g} radii off")


def _summed_degree(given: PointSetRef, options: ipcore.FitOptions) -> int:
    """Return the degree up to which moments are summed.

    Above the plan's `moment_degree` a fit mostly uses the rows themselves. One with the criterion `none` uses all
    moments at once.
    """
    plan = ipcore.plan(given.dimension, given.points, options, normals=True)
    return plan.max_degree if options.criterion is ipcore.Criterion.NONE else plan.moment_degree


def _report(step: ipcore.Step) -> None:
    report(asdict(step))


def _json(result: ipcore.FitResult) -> bytes:
    return orjson.dumps(result.to_dict())


def _point_set(blobs: BlobStore, given: PointSetRef) -> ipcore.PointSet:
    """Return a stored point set. It was checked before it was stored; it is checked again if its summary is missing."""
    table = np.load(BytesIO(_read(blobs, given.key)), allow_pickle=False)
    points, normals = table[:, : given.dimension], table[:, given.dimension :]
    if given.summary is None:
        return ipcore.check_points(points, normals if normals.size else None)
    return given.summary.restored(points, normals if normals.size else None)


def _rows(blobs: BlobStore, key: str, first: int, last: int) -> NDArray[Any]:
    """Return the rows `first` … `last` − 1 of a stored table, without reading the others."""
    head = BytesIO(_read(blobs, key, 0, HEADER_BYTES))
    np.lib.format.read_magic(head)
    shape, _, dtype = np.lib.format.read_array_header_1_0(head)
    start, row = head.tell(), shape[1] * dtype.itemsize
    content = _read(blobs, key, start + first * row, start + last * row)
    return np.frombuffer(content, dtype).reshape(last - first, shape[1])


def _read(blobs: BlobStore, key: str, start: int | None = None, end: int | None = None) -> bytes:
    try:
        return blobs.get(key, start, end)
    except Exception as error:  # the errors of file systems differ, and not all of them can be pickled
        raise NotReadyError(f"the point set cannot be read: {type(error).__name__}: {error}") from error
