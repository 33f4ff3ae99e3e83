"""Point sets too large to be held: read piece by piece, as often as needed, from an array on disk."""

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

LARGE = 1 << 18  # points from which a memory-mapped array is streamed; below, it is read at once
PIECE = 8192  # points at once


@dataclass(frozen=True, eq=False)
class PointStream:
    """Oriented points on disk, and what has to be known of all of them.

    Attributes
    ----------
    points, normals
        (N, d), raw, memory-mapped; normals of any length.
    frame
        Of all points.
    box
        (2, d), raw: their lower and upper corner.
    planar
        Whether 3D points all lie on one plane.
    sample
        Some of the points, raw, with unit normals.
    sha256
        As `digest` defines it.

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
        """Yield raw points and normals, (n, d) each, which have been checked."""
        for (_, x), (_, n) in zip(_read(self.points), _read(self.normals), strict=True):
            yield x, n

    @classmethod
    def of(cls, points: np.ndarray, normals: np.ndarray) -> Self:
        """Look at everything twice: for the centroid, the box and a sample, then for the mean radius and the extents.

        Raises
        ------
        InvalidPointsError, InvalidNormalsError
            As for points that are held.

        """
        validation.check_shape(points.shape)
        digest, total, sample = Digest(points.shape), np.zeros(points.shape[1]), Sample.empty(points.shape[1])
        box = np.stack([np.full(points.shape[1], np.inf), np.full(points.shape[1], -np.inf)])
        for start, piece in _read(points):
            x = validation.matrix("points", piece, InvalidPointsError, start)
            n = validation.unit(normals[start : start + PIECE], x, start)
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
            digest.update(validation.unit(normals[start : start + PIECE], x, start))
        frame = Frame(centre, radius / len(points))
        planar = validation.rank(R, extent, float(np.abs(box).max())) < len(centre)
        return cls(points, normals, frame, box, planar, sample, digest.hexdigest())


def streamed(points: ArrayLike | PointSet, normals: ArrayLike | None) -> PointStream | None:
    """Return the stream as which an array is to be read, or None if it is to be held.

    It is one if it is memory-mapped, has `LARGE` or more points, and normals: estimating them takes all points at once.

    Raises
    ------
    InvalidPointsError, InvalidNormalsError
        If it is a stream and something is wrong with it.

    """
    if not isinstance(points, np.memmap) or normals is None or points.ndim != 2 or len(points) < LARGE:
        return None
    given = np.asanyarray(normals)
    if given.shape != points.shape:
        raise InvalidNormalsError(
            f"normals have shape {given.shape}, the points {points.shape}: they must match", ("normals",)
        )
    return PointStream.of(points, given)


def spooled(chunks: Iterator[Any], normals: ArrayLike | None) -> PointStream:
    """Return the stream of chunks (points, normals), (n, d) each, that an iterator yields.

    One look at them is not enough, so they are written to a temporary file, which is gone with the stream.

    Raises
    ------
    InvalidPointsError, InvalidNormalsError
        If something is wrong with them.

    """
    if normals is not None:
        raise InvalidNormalsError("an iterator yields points with their normals: none go beside it", ("normals",))
    return PointStream.of(*_spooled(chunks))


def _read(array: np.ndarray) -> Iterator[tuple[int, FloatArray]]:
    """Yield pieces in double precision with the row at which they begin."""
    for start in range(0, len(array), PIECE):
        yield start, np.array(array[start : start + PIECE], dtype=np.float64, order="C")
        _forget(array)


def _forget(array: np.ndarray) -> None:
    """Tell the system that what was read of a mapped array need not stay in memory: it counts as this process's."""
    base: Any = array
    while isinstance(base, np.ndarray):
        if isinstance(base, np.memmap) and base.mode == "c":
            return  # what was written to it is in memory only
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)


def _spooled(chunks: Iterator[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Write chunks to a file that is gone with the array, and map it."""
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
    if not isinstance(chunk, tuple) or len(chunk) != 2:
        raise InvalidNormalsError("an iterator must yield pairs of points and normals, (n, d) each")
    x = validation.matrix("points", chunk[0], InvalidPointsError)
    n = validation.matrix("normals", chunk[1], InvalidNormalsError)
    if n.shape != x.shape:
        raise InvalidNormalsError(f"normals have shape {n.shape}, the points {x.shape}: they must match", ("normals",))
    return x, n
