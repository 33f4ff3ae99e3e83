"""The digest by which a fit's input is identified: the SHA-256 of its points and normals."""

import hashlib

import numpy as np

from ipcore._typing import FloatArray


class Digest:
    """The SHA-256 of arrays that are given row by row: of each its shape, then little-endian doubles in C order.

    >>> digest = Digest((2, 2))
    >>> digest.update(np.zeros((1, 2)))
    >>> digest.update(np.ones((1, 2)))
    >>> digest.hexdigest()[:8]
    '5729a384'
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        """Begin with an array of this shape."""
        self._hash = hashlib.sha256()
        self.begin(shape)

    def begin(self, shape: tuple[int, ...]) -> None:
        """Begin the next array."""
        self._hash.update(repr(shape).encode())

    def update(self, rows: FloatArray) -> None:
        """Add the next rows (n, …) of the array."""
        self._hash.update(np.ascontiguousarray(rows, dtype="<f8").data)

    def hexdigest(self) -> str:
        """Return the digest of everything so far, 64 hexadecimal digits."""
        return self._hash.hexdigest()


def sha256(*arrays: FloatArray | None) -> str:
    """Return the digest of whole arrays, of any shape; None is left out."""
    given = [array for array in arrays if array is not None]
    digest = Digest(given[0].shape)
    digest.update(given[0])
    for array in given[1:]:
        digest.begin(array.shape)
        digest.update(array)
    return digest.hexdigest()
