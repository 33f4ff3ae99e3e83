"""Vertices in OFF, with or without faces: OFF, and with normals, colours or texture as NOFF, COFF, STOFF and so on.

Read here, as trimesh fails on a file without faces, and knows no header but OFF and COFF; meshio knows OFF alone.
"""

import re
from itertools import islice

import numpy as np

from service.formats.points import faces
from service.formats.points.reading import Array, RawPoints, ReadOptions, check_count, check_no_columns, shortened
from service.jobs.errors import InvalidInputError, MalformedInputError

_HEADER = re.compile(r"(ST)?(C)?(N)?(?:OFF|off)\b\s*")  # nOFF, with a small n, has any number of dimensions
FACES_PER_POINT = 8  # see ply.ROWS_PER_POINT


def read_off(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the vertices of an OFF file, with the normals that it gives or its faces have.

    Raises
    ------
    MalformedInputError
        If the bytes are not an OFF file.
    InvalidInputError
        If it is one of four dimensions, or binary.
    TooLargeError
        If there are more than `max_points` vertices.

    """
    check_no_columns(options, "OFF")
    text = re.sub(r"#[^\n]*", "", content.decode("utf-8-sig", errors="replace").replace("\r", "\n"))
    try:
        return _read(text.strip(), options.max_points)
    except (ValueError, IndexError) as error:
        raise MalformedInputError(f"not an OFF file: {shortened(str(error), 200)}", ("points",)) from error


def _read(text: str, max_points: int) -> RawPoints:
    header = _HEADER.match(text)
    if header is None:
        if re.match(r"(ST)?C?N?(4n?|n)OFF", text, re.IGNORECASE):
            raise InvalidInputError("only OFF files of three dimensions are read", ("points",))
        raise ValueError("it does not begin with OFF")
    rest = text[header.end() :]
    if rest.upper().startswith("BINARY"):
        raise InvalidInputError("binary OFF is not read", ("points",))
    lines = (line for line in rest.split("\n") if line.strip())
    vertices, polygons = map(int, next(lines, "").split()[:2])
    check_count(vertices, max_points)
    check_count(polygons, FACES_PER_POINT * max_points, "faces")
    if min(vertices, polygons) < 0 or 2 * (vertices + polygons) > len(rest):
        raise ValueError(f"{vertices} vertices and {polygons} faces do not fit into {len(rest)} characters")
    width = 6 if header[3] else 3
    rows = [row.split() for row in islice(lines, vertices)]
    if len(rows) < vertices:
        raise ValueError(f"{vertices} vertices are announced, but there are {len(rows)}")
    table = _numbers(rows, width)
    points = table[:, :3]
    if header[3] and table[:, 3:].any():
        return RawPoints(points, table[:, 3:])
    return RawPoints(points, faces.vertex_normals(points, faces.triangles(_polygons(list(islice(lines, polygons))))))


def _numbers(rows: list[list[str]], width: int) -> Array:
    """Return the first `width` numbers of each row, (N, width). What follows them, such as a colour, is ignored."""
    for i, row in enumerate(rows):
        if len(row) < width:
            raise ValueError(f"vertex {i} has {len(row)} numbers, not {width}")
    return np.array([[float(cell) for cell in row[:width]] for row in rows]).reshape(-1, width)


def _polygons(rows: list[str]) -> list[list[int]]:
    """Return the positions of the vertices of each face. What follows them in a row, such as a colour, is ignored."""
    found = []
    for i, row in enumerate(rows):
        cells = row.split()
        count = faces.position(cells[0])
        corners = [faces.position(cell) for cell in cells[1 : 1 + max(count, 0)]]
        if len(corners) != count:
            raise ValueError(f"face {i} has {len(corners)} vertices, not {cells[0][:20]}")
        found.append(corners)
    return found
