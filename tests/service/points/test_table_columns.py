"""Columns of text tables that no header names: the option says what they are, or the numbers do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.service.points.tables import BALL, NAMES, OUTLINE, QUICK, gives, lines, read, refused, text

# The option


@QUICK
@given(order=st.permutations(range(8)), header=st.booleans())
def test_columns_decides_whatever_the_header_says(order: list[int], header: bool) -> None:
    table = np.hstack([BALL, np.full((30, 2), 9.0)])[:, order]
    names = ",".join([*NAMES, "_", "_"][i] for i in order)
    rows = ["nx,ny,nz,x,y,z,a,b"] if header else []
    assert gives(read(text([*rows, *lines(table)]), columns=names), BALL[:, :3], BALL[:, 3:])


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ("x,y", "names 2 columns, but there are 6"),
        ("x,y,z,nx,ny,nz,_", "names 7 columns, but there are 6"),
        ("x,y,z,i,j,k", "columns has 'i'"),
        ("", "columns has ''"),
        ("_,_,_,_,_,_", "must name x and y"),
        ("x,x,y,_,_,_", "names x more than once"),
        ("x,y,z,nx,_,_", "normals need nx, ny, nz"),
        ("x" * 1000, "columns has 'xxx"),
    ],
)
def test_columns_that_do_not_fit_are_refused(columns: str, says: str) -> None:
    message = refused(text(lines(BALL)), columns)
    assert says in message
    assert len(message) < 300


# Tables without names


@pytest.mark.parametrize("width", [4, 5, 6, 7, 8, 11, 12, 40])
def test_columns_that_nobody_names_are_refused_with_an_example(width: int) -> None:
    table = np.hstack([BALL[:, :3], np.linspace(3.0, 99.0, 30 * width).reshape(30, width)])[:, :width]
    message = refused(text(lines(table)))
    example = message.split("for example columns=")[1].split(" ")[0]
    assert example.count(",") == width - 1
    if "nx" not in example:
        assert gives(read(text(lines(table)), columns=example), BALL[:, :3])


def test_one_column_is_refused() -> None:
    assert "points need at least two columns" in refused(text(lines(OUTLINE[:, :1])))


@pytest.mark.parametrize("scale", [0.901, 0.95, 1.0, 1.05, 1.099])
@pytest.mark.parametrize("d", [2, 3])
def test_a_second_half_of_unit_length_within_a_tenth_is_normals(scale: float, d: int) -> None:
    normals = BALL[:20, 3:] if d == 3 else (OUTLINE - OUTLINE.mean(axis=0)) / [2.5, 1.8]
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    points = BALL[:20, :3] if d == 3 else OUTLINE
    assert gives(read(text(lines(np.hstack([points, scale * normals])))), points, normals)


@pytest.mark.parametrize("scale", [0.0, 0.1, 0.89, 1.11, 2.0, 1e9, 1e300])
@pytest.mark.parametrize("d", [2, 3])
def test_a_second_half_of_another_length_is_refused(scale: float, d: int) -> None:
    table = np.hstack([BALL[:, :d], scale * BALL[:, 3 : 3 + d] / np.linalg.norm(BALL[:, 3 : 3 + d], axis=1)[:, None]])
    assert "columns=" in refused(text(lines(table)))


def test_one_row_of_another_length_is_enough() -> None:
    table = BALL.copy()
    table[17, 3:] *= 1.2
    assert "not normals" in refused(text(lines(table)))


@pytest.mark.parametrize("most", [1, 2, 255])
@pytest.mark.parametrize("d", [2, 3])
def test_whole_numbers_up_to_255_are_colours(most: int, d: int) -> None:
    colours = np.random.default_rng(most).integers(0, most + 1, (30, d)).astype(float)
    message = refused(text(lines(np.hstack([BALL[:, :d], colours]))))
    assert "as colours do" in message
    assert f"columns=x,y,z,{'_,_,_' if d == 3 else '_'}" in message


def test_axis_parallel_normals_of_a_box_are_normals() -> None:
    normals = np.vstack([np.eye(3), -np.eye(3)] * 5)
    points = 2.0 * normals + BALL[:, [1, 2, 0]] * (normals == 0.0)
    assert gives(read(text(lines(np.hstack([points, normals])))), points, normals)
