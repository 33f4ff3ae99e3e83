"""Point sets too large to be held in memory: read piece by piece, as often as needed, from an array on disk."""

import mmap
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ipcore._typing import FloatArray
from ipcore.errors import InvalidNormalsError, InvalidPointsError
from ipcore.points import validation
from ipcore.points.digest import Digest
from ipcore.points.sample import Sample
from ipcore.points.validation import PointSet
from ipcore.polynomial.frame import Frame

STREAMED_POINTS = (
    1 << 18
)  # a memory-mapped array with so many points or more is streamed; a smaller one is read at once
PIECE_POINTS = 8192  # points that are read at once


@dataclass(frozen=True, eq=False)
class PointStream:
    """Oriented points on disk, and the figures of all of them that a fit needs.

    Attributes
    ----------
    points, normals
        (N, d), raw, memory-mapped; normals of any length.
    frame
        The normalised frame, that of all points.
    box
        (2, d), raw: the lower and upper corner of all points.
    planar
        Whether 3D points all lie on one plane.
    sample
        Some of the points, raw, with unit normals.
    sha256
        The digest of points and unit normals, as `digest` defines it.

    """

    points: np.ndarray
    normals: np.ndarray
    frame: Frame
    box: FloatArray
    planar: bool
    sample: Sample
    sha256: str

    @property
    def count(self) -> int:
        """Return N."""
        return len(self.points)

    def pieces(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield raw points and their normals, (n, d) each, in order, until all are read."""
        for (_, x), (_, n) in zip(_read(self.points), _read(self.normals), strict=True):
            yield x, n

    @classmethod
    def of(cls, points: np.ndarray, normals: np.ndarray) -> Self:
        """Return the stream of points and normals (N, d), both read twice.

        The first pass validates them and gives the centroid, the box and a sample, the second the mean radius and the
        principal extents.

        Raises
        ------
        InvalidPointsError, InvalidNormalsError
            As for points that are held in memory, see `validation`.

        """
        validation.check_shape(points.shape)
        digest, total, sample = Digest(points.shape), np.zeros(points.shape[1]), Sample.empty(points.shape[1])
        box = np.stack([np.full(points.shape[1], np.inf), np.full(points.shape[1], -np.inf)])
        for start, piece in _read(points):
            x = validation.matrix("points", piece, InvalidPointsError, start)
            n = validation.unit(normals[start : start + PIECE_POINTS], x, start)
            total += x.sum(axis=0)
            box = np.stack([np.minimum(box[0], x.min(axis=0)), np.maximum(box[1], x.max(axis=0))])
            sample = sample.with_more(Sample.of(x, n))
            digest.update(x)
        centre = total / len(points)
        digest.begin(normals.shape)
        extent = validation.extent(box - centre, box)
        radius, R = 0.0, np.zeros((0, points.shape[1]))
        for start, x in _read(points):
            centred = x - centre
            radius += float(np.linalg.norm(centred, axis=1).sum())
            R = np.asarray(np.linalg.qr(np.vstack([R, centred / extent]), mode="r"))
            digest.update(validation.unit(normals[start : start + PIECE_POINTS], x, start))
        frame = Frame(centre, radius / len(points))
        planar = validation.rank(R, extent, float(np.abs(box).max())) < len(centre)
        return cls(points, normals, frame, box, planar, sample, digest.hexdigest())


def streamed(points: ArrayLike | PointSet, normals: ArrayLike | None) -> PointStream | None:
    """Return the stream of points and normals (N, d), or None if the points are to be held in memory.

    Points are streamed if they are memory-mapped, at least `STREAMED_POINTS`, and have normals: to estimate normals
    takes all points at once.

    Raises
    ------
    InvalidPointsError, InvalidNormalsError
        If they are streamed and something is wrong with them.

    """
    if not isinstance(points, np.memmap) or normals is None or points.ndim != 2 or len(points) < STREAMED_POINTS:
        return None
    given = np.asanyarray(normals)
    if given.shape != points.shape:
        raise InvalidNormalsError(
            f"normals have shape {given.shape}, the points {points.shape}: they must match", ("normals",)
        )
    return PointStream.of(points, given)


def spooled(chunks: Iterator[Any], normals: ArrayLike | None) -> PointStream:
    """Return the stream of the pairs (points, normals), (n, d) each, that an iterator yields; `normals` must be None.

    They are needed more than once, so they are written to a temporary file, which is deleted with the stream.

    Raises
    ------
    InvalidPointsError, InvalidNormalsError
        If something is wrong with them.

    """
    if normals is not None:
        raise InvalidNormalsError("an iterator yields points with their normals: none go beside it", ("normals",))
    return PointStream.of(*_spooled(chunks))


def _read(array: np.ndarray) -> Iterator[tuple[int, FloatArray]]:
    """Yield the pieces (n, d) of an array (N, d) in double precision, each with the number of its first row."""
    for start in range(0, len(array), PIECE_POINTS):
        yield start, np.array(array[start : start + PIECE_POINTS], dtype=np.float64, order="C")
        _release(array)


def _release(array: np.ndarray) -> None:
    """Let the system free the pages of a mapped array that have been read: they count as the process's memory."""
    base: Any = array
    while isinstance(base, np.ndarray):
        if isinstance(base, np.memmap) and base.mode == "c":
            return  # a private copy: what was written to it is in memory only
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)


def _spooled(chunks: Iterator[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Write chunks to a temporary file, and return it memory-mapped: all points and all normals, (N, d) each."""
    with tempfile.TemporaryFile() as file:
        width = None
        for chunk in chunks:
            x, n = _pair(chunk)
            if width not in {None, x.shape[1]}:
                raise InvalidPointsError(f"chunks have {width} and {x.shape[1]} columns", ("points",))
            width = x.shape[1]
            file.write(np.hstack([x, n]).astype("<f8").tobytes())
        file.flush()
        if width is None or file.tell() == 0:
            raise InvalidPointsError("the iterator yields no points", ("points",))
        table = np.memmap(file, dtype="<f8", mode="r").reshape(-1, 2 * width)
    return table[:, :width], table[:, width:]


def _pair(chunk: Any) -> tuple[FloatArray, FloatArray]:  # noqa: ANN401 - whatever the caller's iterator yields
    """Return the points and normals (n, d) of one pair that a caller's iterator yields, validated."""
    if not isinstance(chunk, tuple) or len(chunk) != 2:
        raise InvalidNormalsError("an iterator must yield pairs of points and normals, (n, d) each")
    x = validation.matrix("points", chunk[0], InvalidPointsError)
    n = validation.matrix("normals", chunk[1], InvalidNormalsError)
    if n.shape != x.shape:
        raise InvalidNormalsError(f"normals have shape {n.shape}, the points {x.shape}: they must match", ("normals",))
    return x, n
