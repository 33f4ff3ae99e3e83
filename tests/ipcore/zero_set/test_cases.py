"""The table of cases against what any of its surfaces must be: closed within the cell, and of the same face rules."""

import numpy as np
import pytest

from ipcore.zero_set.cases import LOOP_CENTRE, cases

CUBE, SQUARE = cases(3), cases(2)
RIM = [  # the edges round each face
    {e for e, (low, axis) in enumerate(CUBE.edges.tolist()) if low in face and low + (1 << (2 - axis)) in face}
    for face in CUBE.faces.tolist()
]


def sides(cell: list[int]) -> list[tuple[int, int]]:
    return [(cell[k - 1], cell[k]) for k in range(3)]


def rows() -> list[tuple[int, int, list[list[int]]]]:
    """Return the bits of the inside corners and of the choices, and the triangles, of every case."""
    found = zip(*np.nonzero(CUBE.row >= 0), strict=True)
    return [(int(inside), int(flags), triangles(int(CUBE.row[inside, flags]))) for inside, flags in found]


def triangles(row: int) -> list[list[int]]:
    found: list[list[int]] = CUBE.corners[row, : CUBE.count[row]].tolist()
    return found


def test_every_choice_on_ambiguous_faces_has_its_row() -> None:
    for table in (CUBE, SQUARE):
        for inside, doubtful in enumerate(table.ambiguous.tolist()):
            choices = 2 ** doubtful.bit_count()
            given = np.flatnonzero(table.row[inside] >= 0)
            assert len(given) == choices
            assert (given & ~doubtful == 0).all()


def test_corners_lie_on_just_the_crossed_edges() -> None:
    ends = [(low, low + (1 << (2 - axis))) for low, axis in CUBE.edges.tolist()]
    for inside, _, cells in rows():
        used = {edge for cell in cells for edge in cell} - {LOOP_CENTRE}
        assert used == {e for e, (a, b) in enumerate(ends) if (inside >> a & 1) != (inside >> b & 1)}


def test_sides_within_the_cell_are_used_once_either_way_and_the_others_lie_on_faces() -> None:
    for _, _, cells in rows():
        used = [side for cell in cells for side in sides(cell)]
        assert len(set(used)) == len(used)
        for a, b in used:
            assert sum({a, b} <= rim for rim in RIM) == (0 if (b, a) in used else 1)


@pytest.mark.parametrize("axis", range(3))
def test_neighbours_have_the_same_segments_on_their_common_face_the_other_way_round(axis: int) -> None:
    """They depend on the face's corners and the choice made there, whatever the rest of either cell is."""
    digit = 1 << (2 - axis)
    seen: dict[tuple[int, bool], set[tuple[tuple[tuple[int, int], ...], ...]]] = {}
    for side, shift in ((2 * axis, digit), (2 * axis + 1, 0)):  # the lower cell's high face, the higher one's low face
        face = [c - shift for c in CUBE.faces[side].tolist()]
        for inside, flags, cells in rows():
            cut = [s for cell in cells for s in sides(cell) if set(s) <= RIM[side]]
            ends = [tuple((CUBE.edges[e, 0] - shift, CUBE.edges[e, 1]) for e in s) for s in cut]
            bits = sum((inside >> (c + shift) & 1) << c for c in face)
            way = sorted(ends if shift else [end[::-1] for end in ends])
            seen.setdefault((bits, bool(flags >> side & 1)), set()).add(tuple(way))
    assert len(seen) == 16 + 2
    assert all(len(kinds) == 1 for kinds in seen.values())


@pytest.mark.parametrize(("joined", "expected"), [(0, [[0, 2], [1, 3]]), (1, [[0, 3], [1, 2]])])
def test_square_with_opposite_corners_inside(joined: int, expected: list[list[int]]) -> None:
    assert SQUARE.edges.tolist() == [[0, 0], [1, 0], [0, 1], [2, 1]]  # bottom, top, left, right
    row = SQUARE.row[0b1001, joined]  # bottom left and top right
    assert SQUARE.corners[row, : SQUARE.count[row]].tolist() == expected
