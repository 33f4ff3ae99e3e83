"""A sample of oriented points that does not depend on the order or the pieces in which they come.

Every point gets a key, a hash of its coordinates, and those with the smallest keys are kept (bottom-k sampling, Cohen
and Kaplan 2007). The sample of two sets together is that of their two samples, and no random numbers are drawn.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore._typing import FloatArray

SIZE = 50_000  # points: a mean over them is off by 1/200 of the spread, and their neighbours tell the surface
# From splitmix64 (Steele, Lea and Flood 2014): odd constants whose products spread every bit.
MULTIPLIERS = (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
SHIFT = 29


@dataclass(frozen=True, eq=False)
class Sample:
    """Some points (n, d) with their unit normals (n, d), in the order of their keys (n,)."""

    points: FloatArray
    normals: FloatArray
    keys: np.ndarray

    @classmethod
    def empty(cls, d: int) -> Self:
        """Return no points in d dimensions."""
        return cls(np.zeros((0, d)), np.zeros((0, d)), np.zeros(0, dtype=np.uint64))

    @classmethod
    def of(cls, points: FloatArray, normals: FloatArray, size: int = SIZE) -> Self:
        """Return at most `size` of these points.

        >>> line = np.column_stack([np.arange(9.0), np.zeros(9)])
        >>> halves = Sample.of(line[:4], line[:4], 3).with_more(Sample.of(line[4:], line[4:], 3), 3)
        >>> bool((halves.points == Sample.of(line[::-1], line[::-1], 3).points).all())
        True
        """
        return cls(points, normals, _keys(points)).first(size)

    def with_more(self, other: "Sample", size: int = SIZE) -> Self:
        """Return the sample of both sets together."""
        columns = [(self.points, other.points), (self.normals, other.normals), (self.keys, other.keys)]
        return type(self)(*(np.concatenate(column) for column in columns)).first(size)

    def first(self, size: int) -> Self:
        """Return the points with the smallest keys, in their order."""
        some = np.argpartition(self.keys, size)[:size] if len(self.keys) > size else np.arange(len(self.keys))
        order = some[np.argsort(self.keys[some], kind="stable")]
        return type(self)(self.points[order], self.normals[order], self.keys[order])


def _keys(points: FloatArray) -> np.ndarray:
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64)  # + 0.0: −0 is 0
    keys = np.zeros(len(points), dtype=np.uint64)
    for column in bits.T:
        keys ^= column
        for multiplier in MULTIPLIERS:
            keys ^= keys >> np.uint64(SHIFT)
            keys *= np.uint64(multiplier)
    return keys ^ (keys >> np.uint64(SHIFT))
