"""The header of a PLY file: its elements, their properties, and where the data begin."""

from dataclasses import dataclass

import numpy as np

# The names of types in PLY files, the original ones and those that numpy-minded programs write.
TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST_HEADER = 65_536  # bytes
MOST_PROPERTIES = 1000  # of one element: Gaussian splats have 62


@dataclass(frozen=True)
class Property:
    """A property of an element.

    Attributes
    ----------
    name
        As in the file.
    dtype
        Of its value, or of the entries of its list.
    count_dtype
        Of the number in front of its list; None if it is no list.

    """

    name: str
    dtype: np.dtype[np.generic]
    count_dtype: np.dtype[np.generic] | None = None


@dataclass(frozen=True)
class Element:
    """A kind of row, such as `vertex` or `face`.

    Attributes
    ----------
    name
        As in the file.
    count
        Rows that the header announces; nothing vouches for it.
    properties
        In their order.

    """

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def lists(self) -> bool:
        """Return whether a property is a list, so that rows differ in length."""
        return any(one.count_dtype is not None for one in self.properties)

    @property
    def shortest_row(self) -> int:
        """Return the bytes of a binary row whose lists are empty."""
        return sum((one.count_dtype or one.dtype).itemsize for one in self.properties)


@dataclass(frozen=True)
class Header:
    """A header.

    Attributes
    ----------
    ascii
        Whether the data are text.
    elements
        In the order of their data.
    size
        Bytes of the header, behind which the data begin.

    """

    ascii: bool
    elements: tuple[Element, ...]
    size: int


def parse(content: bytes) -> Header:
    """Return the header of a PLY file.

    Raises
    ------
    ValueError
        If it is none; the message says why.

    """
    lines, size = _lines(content)
    if lines[0] != "ply":
        raise ValueError("the first line is not 'ply'")
    order: str | None = None
    elements: list[tuple[str, int, list[Property]]] = []
    for line in lines[1:]:
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                continue
            case ["format", name, _] if order is None and name in BYTE_ORDERS:
                order = BYTE_ORDERS[name]
            case ["element", name, number] if number.isascii() and number.isdecimal() and len(number) < 19:
                elements.append((name, int(number), []))
            case ["property", *words] if order is not None and elements and len(elements[-1][2]) < MOST_PROPERTIES:
                elements[-1][2].append(_property(words, order))
            case _:
                raise ValueError(f"{line[:60]!r} has no place in a PLY header")
    if order is None:
        raise ValueError("the header does not say its format")
    if any(len({one.name for one in p}) < len(p) for _, _, p in elements):
        raise ValueError("two properties of an element have one name")
    return Header(order == "", tuple(Element(name, n, tuple(p)) for name, n, p in elements), size)


def _lines(content: bytes) -> tuple[list[str], int]:
    """Return the header's lines without `end_header`, and the bytes that it takes."""
    head = content[:LONGEST_HEADER]
    lines: list[str] = []
    start = 0
    while True:
        ends = [end for mark in (b"\n", b"\r") if (end := head.find(mark, start)) >= 0]
        if not ends:
            raise ValueError("the header has no end")
        end = min(ends)
        line = head[start:end].decode("ascii", errors="replace").strip()
        start = end + (2 if head[end : end + 2] == b"\r\n" else 1)
        if line == "end_header":
            return lines or [""], start
        lines.append(line)


def _property(words: list[str], order: str) -> Property:
    match words:
        case ["list", count, kind, name] if count in TYPES and kind in TYPES and TYPES[count][0] != "f":
            return Property(name, _dtype(kind, order), _dtype(count, order))
        case [kind, name] if kind in TYPES:
            return Property(name, _dtype(kind, order))
    raise ValueError(f"a property is not known: {' '.join(words)[:60]!r}")


def _dtype(kind: str, order: str) -> np.dtype[np.generic]:
    return np.dtype((order or "<") + TYPES[kind])
