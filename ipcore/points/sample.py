"""A sample of oriented points that does not depend on the order in which they come, or on how they are divided.

Every point gets a key, a hash of its coordinates, and the points with the smallest keys are kept (bottom-k sampling,
Cohen and Kaplan 2007). The sample of a union of sets is that of the union of their samples. No random numbers are
drawn.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore._typing import FloatArray

SAMPLE_SIZE = 50_000  # points: the error of a mean over them is 1/200 of the spread, and they are dense on the surface
# From splitmix64 (Steele, Lea and Flood 2014): odd constants, multiplication by which spreads every bit.
HASH_MULTIPLIERS = (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
HASH_SHIFT = 29


@dataclass(frozen=True, eq=False)
class Sample:
    """Some points (n, d), their unit normals (n, d) and keys (n,), in ascending order of the keys."""

    points: FloatArray
    normals: FloatArray
    keys: np.ndarray

    @classmethod
    def empty(cls, d: int) -> Self:
        """Return a sample without points in d dimensions."""
        return cls(np.zeros((0, d)), np.zeros((0, d)), np.zeros(0, dtype=np.uint64))

    @classmethod
    def of(cls, points: FloatArray, normals: FloatArray, size: int | None = None) -> Self:
        """Return at most `size`, by default `SAMPLE_SIZE`, of these points (N, d), with their unit normals (N, d).

        >>> line = np.column_stack([np.arange(9.0), np.zeros(9)])
        >>> halves = Sample.of(line[:4], line[:4], 3).with_more(Sample.of(line[4:], line[4:], 3), 3)
        >>> bool((halves.points == Sample.of(line[::-1], line[::-1], 3).points).all())
        True
        """
        return cls(points, normals, _keys(points)).first(size or SAMPLE_SIZE)

    def with_more(self, other: "Sample", size: int | None = None) -> Self:
        """Return the sample, of at most `size` points, by default `SAMPLE_SIZE`, of the union of both sets."""
        columns = [(self.points, other.points), (self.normals, other.normals), (self.keys, other.keys)]
        return type(self)(*(np.concatenate(column) for column in columns)).first(size or SAMPLE_SIZE)

    def first(self, size: int) -> Self:
        """Return the `size` points with the smallest keys, in the order of the keys."""
        some = np.argpartition(self.keys, size)[:size] if len(self.keys) > size else np.arange(len(self.keys))
        order = some[np.argsort(self.keys[some], kind="stable")]
        return type(self)(self.points[order], self.normals[order], self.keys[order])


def _keys(points: FloatArray) -> np.ndarray:
    """Return the keys (N,) of points (N, d), unsigned 64-bit numbers."""
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64)  # + 0.0: −0 is 0
    keys = np.zeros(len(points), dtype=np.uint64)
    for column in bits.T:
        keys ^= column
        for multiplier in HASH_MULTIPLIERS:
            keys ^= keys >> np.uint64(HASH_SHIFT)
            keys *= np.uint64(multiplier)
    return keys ^ (keys >> np.uint64(HASH_SHIFT))
