"""The cases of marching squares and cubes: which edges of a grid cell the zero set crosses, and how it connects them.

A corner is inside where f < 0. On each face the crossed edges are joined by segments. Where all four edges of a face
are crossed, the asymptotic decider (Nielson and Hamann 1991) says whether the two inside corners are connected. The
segments of a cell form closed loops, which are filled with triangles. No triangle has a side that joins two edges of
one face unless the segment there does, for the neighbouring cell could have the same side. What happens on a face
depends on its four values alone, so neighbouring cells agree, and every surface is a closed manifold.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product

import numpy as np

from ipcore._typing import IntArray

LOOP_CENTRE = 12  # the number of a loop's centre, after the 12 edges of a cube; at most one loop of a cube needs it
Tuples = list[tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Cases:
    """The table of all cases of a cell in d dimensions.

    The bits of a corner's number say at which end of each axis it lies, the first axis's bit being the highest. A case
    is given by two numbers: the bits of the inside corners, and the bits of the ambiguous faces whose inside corners
    are connected.

    Attributes
    ----------
    edges
        (E, 2), the lower corner and the axis of each edge.
    faces
        (F, 4), the corners of each face, counter-clockwise seen from outside the cell. In 2D the cell is the face.
    ambiguous
        (2^2^d,), by the bits of the inside corners: the bits of the faces whose four edges are all crossed.
    row
        (2^2^d, 2^F), by the two numbers of a case: its row in `count` and `corners`; −1 if a face has a bit that is not
        ambiguous.
    count
        (rows,), the number of segments or triangles.
    corners
        (rows, most, d), the edges on which the ends of segments or the corners of triangles lie. In 3D the first corner
        may be `LOOP_CENTRE`, the centre of a loop.

    """

    edges: IntArray
    faces: IntArray
    ambiguous: IntArray
    row: IntArray
    count: IntArray
    corners: IntArray


@lru_cache(maxsize=2)
def cases(d: int) -> Cases:
    """Return the table for d = 2 or 3.

    >>> table = cases(3)
    >>> table.count[table.row[[0b1, 0b1111], 0]].tolist()       # a triangle cuts off a corner, two cut off a face
    [1, 2]
    """
    edges: Tuples = [(corner, axis) for axis in range(d) for corner in range(2**d) if not corner & _bit(d, axis)]
    faces = _faces(d)
    rims = [_rim(face, edges) for face in faces]
    same_face = {frozenset((a, b)) for rim in rims for a in rim for b in rim}
    ambiguous: list[int] = []
    cells: list[Tuples] = []
    row = np.full((2**2**d, 2 ** len(faces)), -1)
    for inside in range(2**2**d):
        doubtful = [k for k, face in enumerate(faces) if _is_ambiguous(inside, face)]
        ambiguous.append(_bits(doubtful))
        for choice in product((False, True), repeat=len(doubtful)):
            connected = [k for k, chosen in zip(doubtful, choice, strict=True) if chosen]
            row[inside, _bits(connected)] = len(cells)
            segments = _segments(inside, faces, rims, connected)
            cells.append([*sorted(segments.items())] if d == 2 else _triangles(segments, same_face))
    corners = np.zeros((len(cells), max(map(len, cells)), d), dtype=np.intp)
    for place, cell in zip(corners, cells, strict=True):
        place[: len(cell)] = np.reshape(cell, (-1, d))
    count = np.array([len(cell) for cell in cells])
    return Cases(np.array(edges), np.array(faces), np.array(ambiguous), row, count, corners)


def _bit(d: int, axis: int) -> int:
    """Return the bit of an axis in the number of a corner."""
    return 1 << (d - 1 - axis)


def _bits(places: list[int]) -> int:
    """Return the number that has its 1s at these places."""
    return sum(1 << k for k in places)


def _faces(d: int) -> Tuples:
    """Return the corners of each face, counter-clockwise seen from outside; in 2D those of the cell."""
    if d == 2:
        return [(0, 2, 3, 1)]
    faces: Tuples = []
    for axis in range(3):
        w, u, v = (_bit(3, (axis + k) % 3) for k in range(3))  # u × v points along w
        faces += [(w, w + u, w + u + v, w + v), (0, v, u + v, u)]
    return faces


def _is_ambiguous(inside: int, face: tuple[int, ...]) -> bool:
    """Return whether all four edges of a face are crossed, given the bits of the inside corners."""
    a, b, c, d = (inside >> corner & 1 for corner in face)
    return a == c and b == d and a != b


def _rim(face: tuple[int, ...], edges: Tuples) -> list[int]:
    """Return the numbers of the four edges around a face: the edge from each corner to the next."""
    d = 1 + max(axis for _, axis in edges)
    number = {frozenset((low, low + _bit(d, axis))): e for e, (low, axis) in enumerate(edges)}
    return [number[frozenset(ends)] for ends in zip(face, face[1:] + face[:1], strict=True)]


def _segments(inside: int, faces: Tuples, rims: list[list[int]], connected: list[int]) -> dict[int, int]:
    """Return the segments on all faces, as a map from the edge where one starts to the edge where it ends.

    Seen from outside the cell, the inside is on their left: along the rim of a face, a segment starts where the rim
    leaves the inside and ends where the rim enters it. `connected` are the ambiguous faces whose inside corners are
    connected: there the segment goes around an outside corner, on the other ambiguous faces around an inside corner.
    """
    segments: dict[int, int] = {}
    for k, (face, rim) in enumerate(zip(faces, rims, strict=True)):
        bits = [inside >> corner & 1 for corner in face]
        leaving = [i for i in range(4) if bits[i] and not bits[(i + 1) % 4]]
        entering = [i for i in range(4) if not bits[i] and bits[(i + 1) % 4]]
        if len(leaving) == 2:
            entering = [(i + (1 if k in connected else -1)) % 4 for i in leaving]
        segments |= {rim[i]: rim[j] for i, j in zip(leaving, entering, strict=True)}
    return segments


def _triangles(segments: dict[int, int], same_face: set[frozenset[int]]) -> Tuples:
    """Return triangles that fill the loops, counter-clockwise seen from the outside of the zero set.

    `same_face` holds the pairs of edges that lie on a common face.
    """
    rest = dict(segments)
    triangles: Tuples = []
    while rest:
        loop = [next(iter(rest))]
        while loop[-1] in rest:
            loop.append(rest.pop(loop[-1]))
        loop = loop[:0:-1]  # without the repeated first edge; reversed, for the inside was on the left from outside
        fan = _fan(loop, same_face)
        triangles += fan or [(LOOP_CENTRE, a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]
    return triangles


def _fan(loop: list[int], same_face: set[frozenset[int]]) -> Tuples:
    """Return the triangles from one of a loop's edges to all others, none of whose chords lies on a face.

    None are returned if every choice of the first edge has such a chord.
    """
    for k in range(len(loop)):
        first, *others = loop[k:] + loop[:k]
        if not any(frozenset((first, other)) in same_face for other in others[1:-1]):
            return [(first, a, b) for a, b in pairwise(others)]
    return []
