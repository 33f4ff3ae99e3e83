"""Files of surfaces as bytes, written some rows at a time, so that a file takes hardly more memory than itself."""

from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import chain
from typing import Any

from numpy.typing import NDArray

Table = NDArray[Any]

BLOCK_ROWS = 1 << 15  # rows at once: 2 MB of the longest, those of STL


def joined(*parts: Iterable[bytes]) -> bytes:
    """Return the bytes of all parts one after another. They are collected in memory and returned without a copy."""
    out = BytesIO()
    for part in chain(*parts):
        out.write(part)
    return out.getvalue()


def blocks(table: Table) -> Iterator[Table]:
    """Yield an array (n, …) in blocks of at most `BLOCK_ROWS` rows."""
    return (table[start : start + BLOCK_ROWS] for start in range(0, len(table), BLOCK_ROWS))


def uint32(*numbers: int) -> bytes:
    """Return numbers as little-endian unsigned integers of 4 bytes each."""
    return b"".join(number.to_bytes(4, "little") for number in numbers)
