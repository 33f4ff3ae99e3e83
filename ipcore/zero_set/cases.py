"""The cases of marching squares and cubes: which edges of a grid cell the zero set crosses, and how it connects them.

A corner is inside where f < 0. On each face the crossed edges are joined by segments; where all four are crossed, the
asymptotic decider (Nielson and Hamann 1991) says whether the inside corners hang together. The segments close to loops,
which are filled with triangles. No chord joins two edges of one face, for the neighbour could have the same one. What
happens on a face depends on its four values alone, so neighbours agree, and surfaces are closed manifolds in any case.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product

import numpy as np

from ipcore._typing import BoolArray, IntArray

MIDDLE = 12  # of a loop, counted behind the 12 edges of a cube; at most one loop of a cube needs one
Tuples = list[tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Cases:
    """The table for cells in d dimensions. Corner c lies at the binary digits of c, the first axis's the highest.

    Attributes
    ----------
    edges
        (E, 2), the lower corner and the axis of each edge.
    faces
        (F, 4), the corners of each face, counter-clockwise seen from outside. In 2D it is the cell.
    ambiguous
        (2^2^d,), by the bits of the inside corners: bits of the faces whose four edges are all crossed.
    row
        (2^2^d, 2^F): by the bits of the inside corners, and of the ambiguous faces whose inside hangs together: the
        row of the following. −1 if a face that is not ambiguous has a bit.
    count
        (rows,), how many segments or triangles.
    corners
        (rows, most, d), the edges on which their corners lie. In 3D the first may be E: the middle of a loop.
    middle
        (rows,), whether there is such a middle; there is never more than one.

    """

    edges: IntArray
    faces: IntArray
    ambiguous: IntArray
    row: IntArray
    count: IntArray
    corners: IntArray
    middle: BoolArray


@lru_cache(maxsize=2)
def cases(d: int) -> Cases:
    """Return the table for d = 2 or 3.

    >>> table = cases(3)
    >>> table.count[table.row[[0b1, 0b1111], 0]].tolist()       # a corner is cut off by a triangle, a face by two
    [1, 2]
    """
    edges: Tuples = [(corner, axis) for axis in range(d) for corner in range(2**d) if not corner & _digit(d, axis)]
    faces = _faces(d)
    rounds = [_edges_round(face, edges) for face in faces]
    flat = {frozenset((a, b)) for round_ in rounds for a in round_ for b in round_}
    ambiguous: list[int] = []
    cells: list[Tuples] = []
    row = np.full((2**2**d, 2 ** len(faces)), -1)
    for inside in range(2**2**d):
        doubtful = [k for k, face in enumerate(faces) if _is_ambiguous(inside, face)]
        ambiguous.append(_bits(doubtful))
        for choice in product((False, True), repeat=len(doubtful)):
            together = [k for k, joined in zip(doubtful, choice, strict=True) if joined]
            row[inside, _bits(together)] = len(cells)
            following = _following(inside, faces, rounds, together)
            cells.append([*sorted(following.items())] if d == 2 else _triangles(following, flat))
    filled = np.zeros((len(cells), max(map(len, cells)), d), dtype=np.intp)
    for place, cell in zip(filled, cells, strict=True):
        place[: len(cell)] = np.reshape(cell, (-1, d))
    count = np.array([len(cell) for cell in cells])
    middle = (filled[:, :, 0] == len(edges)).any(axis=1)
    return Cases(np.array(edges), np.array(faces), np.array(ambiguous), row, count, filled, middle)


def _digit(d: int, axis: int) -> int:
    """Return the digit of an axis in the number of a corner."""
    return 1 << (d - 1 - axis)


def _bits(places: list[int]) -> int:
    return sum(1 << k for k in places)


def _faces(d: int) -> Tuples:
    if d == 2:
        return [(0, 2, 3, 1)]
    faces: Tuples = []
    for axis in range(3):
        w, u, v = (_digit(3, (axis + k) % 3) for k in range(3))  # u × v points along w
        faces += [(w, w + u, w + u + v, w + v), (0, v, u + v, u)]
    return faces


def _is_ambiguous(inside: int, face: tuple[int, ...]) -> bool:
    a, b, c, d = (inside >> corner & 1 for corner in face)
    return a == c and b == d and a != b


def _edges_round(face: tuple[int, ...], edges: Tuples) -> list[int]:
    """Return the edge from each corner of a face to the next."""
    d = 1 + max(axis for _, axis in edges)
    number = {frozenset((low, low + _digit(d, axis))): e for e, (low, axis) in enumerate(edges)}
    return [number[frozenset(ends)] for ends in zip(face, face[1:] + face[:1], strict=True)]


def _following(inside: int, faces: Tuples, rounds: list[list[int]], together: list[int]) -> dict[int, int]:
    """Return the segments on the faces, from edge to edge: seen from outside the cell, the inside is on their left.

    Going round a face, they start where the way leaves the inside and end where it enters it.
    """
    following: dict[int, int] = {}
    for k, (face, round_) in enumerate(zip(faces, rounds, strict=True)):
        bits = [inside >> corner & 1 for corner in face]
        leaving = [i for i in range(4) if bits[i] and not bits[(i + 1) % 4]]
        entering = [i for i in range(4) if not bits[i] and bits[(i + 1) % 4]]
        if len(leaving) == 2:  # the segment goes round the outside corner, or round the inside one
            entering = [(i + (1 if k in together else -1)) % 4 for i in leaving]
        following |= {round_[i]: round_[j] for i, j in zip(leaving, entering, strict=True)}
    return following


def _triangles(following: dict[int, int], flat: set[frozenset[int]]) -> Tuples:
    """Return triangles that fill the loops, counter-clockwise seen from the outside of the zero set."""
    rest = dict(following)
    triangles: Tuples = []
    while rest:
        loop = [next(iter(rest))]
        while loop[-1] in rest:
            loop.append(rest.pop(loop[-1]))
        loop = loop[:0:-1]  # without the repeated first; the inside was on the left of who looked from outside the cell
        fan = _fan(loop, flat)
        triangles += fan or [(MIDDLE, a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]
    return triangles


def _fan(loop: list[int], flat: set[frozenset[int]]) -> Tuples:
    """Return the triangles from one of the loop's edges to all others, or none if each has a chord on a face."""
    for k in range(len(loop)):
        first, *others = loop[k:] + loop[:k]
        if not any(frozenset((first, other)) in flat for other in others[1:-1]):
            return [(first, a, b) for a, b in pairwise(others)]
    return []
