"""Vertices in Wavefront OBJ, with or without faces: `v`, `vn` and `f` lines.

Read here, as trimesh drops the normals of a file without faces and the vertices that no face uses, and meshio pairs
normals with vertices by their order even where faces say otherwise. No material or other file that is named is opened.
"""

from dataclasses import dataclass, field

import numpy as np

from service.formats.points import faces
from service.formats.points.reading import Array, RawPoints, ReadOptions, check_count, check_no_columns, shortened
from service.jobs.errors import MalformedInputError

LINES_PER_POINT = 8  # normals and faces for each point that a file may have; see ply.ROWS_PER_POINT


def read_obj(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the vertices of an OBJ file, in 2D if they have no z, with normals if each has one.

    Without faces, normals belong to vertices in their order. With faces that name normals, the normal of a vertex is
    the mean of those that its faces give it. With faces alone it is worked out from them.

    Raises
    ------
    MalformedInputError
        If a line cannot be read; its number is named.
    TooLargeError
        If there are more than `max_points` vertices.

    """
    check_no_columns(options, "OBJ")
    found = _Statements(options.max_points)
    text = content.decode("utf-8-sig", errors="replace").replace("\\\n", " ").replace("\\\r\n", " ")
    for number, line in enumerate(text.splitlines(), 1):
        try:
            found.read(line.split())
        except (ValueError, IndexError) as error:
            raise MalformedInputError(f"line {number}: {shortened(str(error), 200)}", ("points",)) from error
    if not found.points:
        raise MalformedInputError("there are no vertices (v) in it", ("points",))
    points = np.array(found.points)
    return RawPoints(points, _normals(points, found))


@dataclass
class _Statements:
    """What the lines of a file say.

    Attributes
    ----------
    max_points
        More vertices are refused.
    points, normals
        The vertices, each of 2 or 3 numbers, and the normals, of as many.
    polygons
        The positions of the corners of each face.
    pairs
        Of each corner with a normal, the positions of its vertex and of its normal.

    """

    max_points: int
    points: list[list[float]] = field(default_factory=list)
    normals: list[list[float]] = field(default_factory=list)
    polygons: list[list[int]] = field(default_factory=list)
    pairs: list[tuple[int, int]] = field(default_factory=list)

    def read(self, words: list[str]) -> None:
        """Add one line, whose words these are."""
        match words:
            case ["v", *numbers]:
                self._add(self.points, numbers, 2)
                check_count(len(self.points), self.max_points)
            case ["vn", *numbers]:
                self._add(self.normals, numbers, len(self.points[0]) if self.points else 2)
                check_count(len(self.normals), LINES_PER_POINT * self.max_points, "normals")
            case ["f", *corners]:
                self._add_face([corner.split("/") for corner in corners])
                check_count(len(self.polygons), LINES_PER_POINT * self.max_points, "faces")

    @staticmethod
    def _add(rows: list[list[float]], numbers: list[str], fewest: int) -> None:
        """Add the first two or three numbers; behind those of a vertex may stand a weight or a colour."""
        row = [float(number) for number in numbers[:3]]
        if len(row) < fewest or (rows and len(row) != len(rows[0])):
            raise ValueError(f"{len(row)} numbers, where {len(rows[0]) if rows else fewest} should stand")
        rows.append(row)

    def _add_face(self, corners: list[list[str]]) -> None:
        """Add a face of corners `v`, `v/vt`, `v//vn` or `v/vt/vn`, which count from 1, or back from the last as −1."""
        vertices = [_position(corner[0], len(self.points)) for corner in corners]
        self.polygons.append(vertices)
        for vertex, corner in zip(vertices, corners, strict=True):
            if len(corner) == 3 and corner[2]:
                self.pairs.append((vertex, _position(corner[2], len(self.normals))))


def _position(number: str, count: int) -> int:
    """Return the position, from 0, of what a face calls by this number when there are so many."""
    position = faces.position(number)
    if position == 0:
        raise ValueError("a face has vertex or normal 0, but they count from 1")
    return position - 1 if position > 0 else count + position


def _normals(points: Array, found: _Statements) -> Array | None:
    """Return the normals (N, d) of points (N, d), or None if there are not as many."""
    if found.pairs:
        return _mean_normals(points, np.array(found.normals), np.array(found.pairs))
    if found.normals and len(found.normals) == len(points):
        return np.array(found.normals)
    if found.normals and not found.polygons:
        raise MalformedInputError(
            f"{len(points)} vertices and {len(found.normals)} normals, and no faces that say which belong together",
            ("normals",),
        )
    if points.shape[1] == 2:
        return None
    return faces.vertex_normals(points, faces.triangles(found.polygons))


def _mean_normals(points: Array, normals: Array, pairs: Array) -> Array | None:
    """Return the mean normal (N, d) of each vertex over its distinct normals, or None if one has none.

    Parameters
    ----------
    points, normals
        Vertices (N, d) and normals (K, d).
    pairs
        Positions of a vertex and of a normal, (M, 2).

    """
    if not normals.size or pairs.min() < 0 or (pairs >= (len(points), len(normals))).any():
        raise MalformedInputError("a face names a vertex or a normal that is not there", ("normals",))
    if normals.shape[1] != points.shape[1]:
        raise MalformedInputError("normals have another dimension than vertices", ("normals",))
    distinct = np.unique(pairs, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    sums = np.zeros_like(points)
    np.add.at(sums, distinct[:, 0], unit[distinct[:, 1]])
    length = np.linalg.norm(sums, axis=1)
    return sums if (length > 1e-6).all() else None
