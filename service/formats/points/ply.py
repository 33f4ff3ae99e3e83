"""Point clouds and meshes in PLY: ascii or binary of either byte order, with any properties of any type in any order.

Read here, and by no library, after trying three on the field's files and on 21 variants of them (order and type of the
properties, byte order, faces before vertices, triangles beside quadrangles, lines that end in CR LF, x and y alone):
trimesh refuses 16 of the 24 (x and y alone, and binary files whose faces differ in length); meshio refuses 15 (among
them types beside float and int, and faces before vertices); plyfile reads all, but its licence is the GPL, which this
project cannot take on, and a face takes it 8 µs. With numpy the vertices are one `frombuffer`.
"""

from typing import Any

import numpy as np

from service.formats.points import columns, faces
from service.formats.points.ply_header import Element, Header, Property, parse
from service.formats.points.reading import (
    Array,
    RawPoints,
    ReadOptions,
    check_count,
    check_no_columns,
    doubles,
    shortened,
)
from service.jobs.errors import MalformedInputError

Values = dict[str, Array | list[Array]]
FACE_LISTS = ("vertex_indices", "vertex_index")
# Rows of any element for each point that a file may have: a closed mesh of triangles has 2 faces and 3 edges a vertex.
ROWS_PER_POINT = 8


def read_ply(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the vertices of a PLY file, in 2D if they have no z, with the normals that it gives or its faces have.

    Raises
    ------
    MalformedInputError
        If the bytes are not a PLY file.
    InvalidInputError
        If the vertices have no x and y.
    TooLargeError
        If there are more than `max_points` vertices.

    """
    check_no_columns(options, "PLY")
    try:
        header = parse(content)
        for element in header.elements:
            _check_size(element, header.ascii, len(content) - header.size, options.max_points)
        return _read(header, _Text(content, header.size) if header.ascii else _Binary(content, header.size))
    except ValueError as error:
        raise MalformedInputError(f"not a PLY file: {shortened(str(error), 200)}", ("points",)) from error


def _check_size(element: Element, text: bool, size: int, max_points: int) -> None:  # noqa: FBT001 - of the header
    """Refuse an element with more rows than may be, or than there are bytes for; `text` says how they are written."""
    if element.name == "vertex":
        check_count(element.count, max_points)
    check_count(element.count, ROWS_PER_POINT * max_points, f"rows of {shortened(element.name)}")
    shortest = 2 * len(element.properties) if text else element.shortest_row
    if element.count * shortest > size + 1:  # the last line of a text may have no end
        raise ValueError(f"{element.count} rows of {shortened(element.name)} do not fit into {size} bytes")


def _read(header: Header, data: "_Text | _Binary") -> RawPoints:
    """Return the vertices, and normals of their own or of the faces that are read only if there are none."""
    points: Array | None = None
    polygons: Array | list[Array] = []
    for element in header.elements:
        values = data.read(element)
        if element is header.elements[-1]:
            data.check_end()
        if element.name == "vertex":
            points, normals = _vertices(values)
            if normals is not None and normals.any():  # all zero is how some programs write that there are none
                return RawPoints(points, normals)
        elif element.name == "face":
            polygons = next((values[name] for name in FACE_LISTS if name in values), [])
        if points is not None and len(polygons):
            break
    if points is None:
        raise ValueError("it has no vertices")
    if points.shape[1] == 2 or not len(polygons):
        return RawPoints(points)
    return RawPoints(points, faces.vertex_normals(points, faces.triangles(polygons)))


def _vertices(values: Values) -> tuple[Array, Array | None]:
    """Return points (N, d) and normals (N, d), or None, of the properties of vertices."""
    names = [name for name, value in values.items() if isinstance(value, np.ndarray) and value.ndim == 1]
    found = columns.from_names(names, "the vertex element")
    return found.split(np.stack([doubles(np.asarray(values[name])) for name in names], axis=1))


class _Text:
    """The data of an ascii file: one line for each row."""

    def __init__(self, content: bytes, start: int) -> None:
        """Begin behind the header."""
        self._rows = [line for line in content[start:].replace(b"\r", b"\n").split(b"\n") if line.strip()]
        self._row = 0

    def check_end(self) -> None:
        """Refuse rows that the header does not announce."""
        if self._row < len(self._rows):
            raise ValueError(f"there are {len(self._rows) - self._row} rows more than the header announces")

    def read(self, element: Element) -> Values:
        """Return the values of the next element by property: arrays (N,), and lists of arrays for list properties."""
        rows = self._rows[self._row : self._row + element.count]
        if len(rows) < element.count:
            raise ValueError(f"{element.count} rows of {element.name[:40]} are announced, but there are {len(rows)}")
        self._row += element.count
        if element.lists:
            return _columns(element, [_parsed(row.split(), element.properties) for row in rows])
        cells = b" ".join(rows).split()
        width = len(element.properties)
        if len(cells) != element.count * width or not all(len(row.split()) == width for row in rows):
            raise ValueError(f"a row of {element.name[:40]} has not the {width} values that the header announces")
        table = np.array(list(map(float, cells)), dtype=np.float64).reshape(element.count, width)
        return {one.name: table[:, i] for i, one in enumerate(element.properties)}


def _parsed(cells: list[bytes], properties: tuple[Property, ...]) -> list[Array]:
    """Return the values of one row of text, each as an array."""
    values, i = [], 0
    for one in properties:
        length = 1
        if one.count_dtype is not None:
            length, i = int(cells[i]) if i < len(cells) else -1, i + 1
        if not 0 <= length <= len(cells) - i:
            raise ValueError(f"a row ends within {one.name[:40]}")
        values.append(np.array([float(cell) for cell in cells[i : i + length]]))
        i += length
    return values


class _Binary:
    """The data of a binary file."""

    def __init__(self, content: bytes, start: int) -> None:
        """Begin behind the header."""
        self._content, self._start = content, start

    def check_end(self) -> None:
        """Refuse bytes that the header does not announce; line ends do no harm."""
        rest = self._content[self._start :].strip()
        if rest:
            raise ValueError(f"there are {len(rest)} bytes more than the header announces")

    def read(self, element: Element) -> Values:
        """Return the values of the next element by property: arrays (N,), and lists of arrays for list properties.

        The lists of a property that are all of one length are one array (N, length).
        """
        if element.count == 0 or not element.properties:
            return {one.name: np.empty(0) for one in element.properties}
        lengths = self._lengths(element)
        dtype = np.dtype([field for i, one in enumerate(element.properties) for field in _fields(i, one, lengths[i])])
        size = element.count * dtype.itemsize
        if self._start + size <= len(self._content):
            table = np.frombuffer(self._content, dtype, element.count, self._start)
            if all((table[f"{i}n"] == lengths[i]).all() for i, one in enumerate(element.properties) if one.count_dtype):
                self._start += size
                return {one.name: table[str(i)] for i, one in enumerate(element.properties)}
        if not element.lists:
            raise ValueError(f"the data end within {element.name[:40]}")
        return _columns(element, [self._row(element.properties) for _ in range(element.count)])

    def _lengths(self, element: Element) -> list[int]:
        """Return the lengths of the lists in the first row, without moving on; 1 for a property that is no list."""
        start = self._start
        lengths = [len(value) for value in self._row(element.properties)]
        self._start = start
        return lengths

    def _row(self, properties: tuple[Property, ...]) -> list[Array]:
        """Return the values of the next row, each as an array, and move on."""
        values = []
        for one in properties:
            length = 1
            if one.count_dtype is not None:
                length = int(self._take(one.count_dtype, 1)[0])
            values.append(self._take(one.dtype, length))
        return values

    def _take(self, dtype: np.dtype[np.generic], count: int) -> Array:
        end = self._start + count * dtype.itemsize
        if count < 0 or end > len(self._content):
            raise ValueError("the data end within a row")
        values = np.frombuffer(self._content, dtype, count, self._start)
        self._start = end
        return values


def _fields(i: int, one: Property, length: int) -> list[Any]:
    """Return the fields of property number `i` in a record whose list has this length."""
    if one.count_dtype is None:
        return [(str(i), one.dtype)]
    return [(f"{i}n", one.count_dtype), (str(i), one.dtype, (length,))]


def _columns(element: Element, rows: list[list[Array]]) -> Values:
    """Return the values of an element by property from its rows."""
    values: Values = {}
    for i, one in enumerate(element.properties):
        entries = [row[i] for row in rows]
        values[one.name] = entries if one.count_dtype is not None else np.array([entry[0] for entry in entries])
    return values
