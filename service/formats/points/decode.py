"""Point sets in: bytes or a file of any kind, read without trusting a byte, checked, and made one npy of doubles."""

import hashlib
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np

import ipcore
from service.formats.points import columns as columns_
from service.formats.points.geometry_readers import GEOMETRY_READERS
from service.formats.points.json_body import read_json
from service.formats.points.npy import read_npy
from service.formats.points.npz import read_npz
from service.formats.points.reading import Array, RawPoints, ReadOptions, check_count
from service.formats.points.table import read_table
from service.jobs.errors import InvalidInputError, TooLargeError
from service.jobs.fit import ReceivedPoints
from service.jobs.media_types import Missing
from service.jobs.point_set_summary import PointSetSummary

# By kind of body, which is also the ending of a file. Each reader takes the bytes.
READERS: dict[str, Callable[[bytes, ReadOptions], RawPoints]] = {
    "json": read_json,
    "npy": read_npy,
    "npz": read_npz,
    **dict.fromkeys(("csv", "tsv", "txt", "xyz", "asc"), read_table),
    **GEOMETRY_READERS,
}
# A file of more bytes is not opened: no kind takes so many per point, with faces, colours and all.
FILE_BYTES_PER_POINT = 1024
FILE_BYTES = 1 << 20


def read(
    body: bytes | Path, kind: str, max_points: int, *, columns: str | None = None, missing: Missing = "refuse"
) -> ReceivedPoints:
    """Read and check a point set.

    Parameters
    ----------
    body
        The bytes, or a file that holds them.
    kind
        One of `READERS`, such as `json`, `npy`, `csv` or `ply`.
    max_points
        More are refused before they are turned into numbers.
    columns
        What each column of a table or an array holds, in order, as in `x,y,z,nx,ny,nz,_`; `_` ignores one. None leaves
        it to the header and the rules in `service.formats.points.columns`.
    missing
        `refuse` refuses a point with a value that is missing or not finite, or with a normal of length 0; `drop` leaves
        such points out, and the point set's `left_out` counts them.

    Raises
    ------
    MalformedInputError
        If the bytes are not of that kind.
    InvalidInputError
        If they are, but not a point set that can be fitted.
    TooLargeError
        If there are more points than `max_points`.

    """
    options = ReadOptions(max_points, None if columns is None else columns_.parse(columns), missing)
    return checked(READERS[kind](_content(body, max_points), options), options)


def _content(body: bytes | Path, max_points: int) -> bytes:
    """Return the bytes of a body, unless a file is larger than so many points can be."""
    if isinstance(body, bytes):
        return body
    most = FILE_BYTES + FILE_BYTES_PER_POINT * max_points
    if body.stat().st_size > most:
        raise TooLargeError(f"the file is larger than the {most} bytes that {max_points} points may take")
    return body.read_bytes()


def checked(raw: RawPoints, options: ReadOptions) -> ReceivedPoints:
    """Return points that a reader found as a checked point set.

    Raises
    ------
    InvalidInputError
        If they cannot be fitted.
    TooLargeError
        If there are more points than `max_points`.

    """
    check_count(len(raw.points), options.max_points)
    complete = _without_missing(raw) if options.missing == "drop" else raw
    try:
        given = ipcore.check_points(complete.points, complete.normals)
    except ipcore.IPCoreError as error:
        raise InvalidInputError(_with_remedy(error.message, complete), error.at) from error
    table = given.points if given.normals is None else np.hstack([given.points, given.normals])
    content, (count, dimension) = _npy(table), given.points.shape
    left_out = len(raw.points) - len(complete.points)
    return ReceivedPoints(
        content,
        key=hashlib.sha256(content).hexdigest(),
        dimension=dimension,
        points=count,
        normals=given.normals is not None,
        options=raw.options,
        summary=PointSetSummary.of(given, left_out),
        left_out=left_out,
    )


def _with_remedy(message: str, raw: RawPoints) -> str:
    """Return a message about points, with the option that helps if some of them have values that are not finite."""
    normals = raw.points if raw.normals is None else raw.normals
    finite = np.isfinite(raw.points).all() and np.isfinite(normals).all() and normals.any(axis=1).all()
    return message if finite else f"{message}; missing=drop leaves such points out"


def _without_missing(raw: RawPoints) -> RawPoints:
    """Return the points whose coordinates are finite and whose normals, if there are any, have a direction."""
    points, normals = raw.points, raw.normals
    complete = np.isfinite(points).all(axis=1)
    if normals is not None and normals.shape == points.shape:
        complete &= np.isfinite(normals).all(axis=1) & normals.any(axis=1)
    elif normals is not None:
        return raw  # the check that follows says that they do not belong together
    if not complete.any():
        raise InvalidInputError("every point has a value that is missing, so that none is left", ("points",))
    return replace(raw, points=points[complete], normals=None if normals is None else normals[complete])


def split(content: bytes, dimension: int) -> tuple[Array, Array | None]:
    """Return points (N, d) and normals (N, d), if any, from the npy that `read` made."""
    table = np.load(BytesIO(content), allow_pickle=False)
    return table[:, :dimension], table[:, dimension:] if table.shape[1] > dimension else None


def _npy(table: Array) -> bytes:
    file = BytesIO()
    np.save(file, table, allow_pickle=False)
    return file.getvalue()
