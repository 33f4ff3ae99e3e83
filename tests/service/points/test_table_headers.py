"""Headers of text tables: which column is what, as programs write it."""

import csv
from io import StringIO

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.service.points.tables import BALL, NAMES, OUTLINE, QUICK, gives, lines, read, refused, text


@QUICK
@given(
    order=st.permutations(range(6)),
    upper=st.lists(st.booleans(), min_size=6, max_size=6),
    delimiter=st.sampled_from([",", ";", "\t", " ", "   "]),
    mark=st.sampled_from(["", "# ", "//", "% ", "#"]),
)
def test_a_header_names_columns_in_any_order_and_case(
    order: list[int], upper: list[bool], delimiter: str, mark: str
) -> None:
    names = [NAMES[i].upper() if upper[i] else NAMES[i] for i in order]
    found = read(text([mark + delimiter.join(names), *lines(BALL[:, order], delimiter)]))
    assert gives(found, BALL[:, :3], BALL[:, 3:])


@QUICK
@given(
    order=st.permutations(range(5)),
    others=st.lists(st.sampled_from(["intensity", "r", "time [s]", "id", ""]), min_size=3, max_size=3),
    words=st.lists(
        st.text(st.characters(categories=["L", "Zs", "P"], exclude_characters='"#%/'), max_size=8), min_size=1
    ),
)
def test_columns_with_other_names_are_ignored_whatever_they_hold(
    order: list[int], others: list[str], words: list[str]
) -> None:
    cells = [[*map(repr, map(float, row)), words[i % len(words)], "", "7"] for i, row in enumerate(OUTLINE)]
    names = ["x", "y", *others]
    out = StringIO()
    writer = csv.writer(out)
    writer.writerow([names[i] for i in order])
    writer.writerows([[row[i] for i in order] for row in cells])
    assert gives(read(out.getvalue()), OUTLINE)


@pytest.mark.parametrize(
    "header",
    [
        "x,y,z,normal_x,normal_y,normal_z",
        "X,Y,Z,NormalX,NormalY,NormalZ",
        '"x","y","z","nx","ny","nz"',
        "x [mm],y [mm],z [mm],nx,ny,nz",
        "x (m), y (m), z (m), n_x, n_y, n_z",
        "Points:0,Points:1,Points:2,Normals:0,Normals:1,Normals:2",
        "# x y z nx ny nz",
        "//X Y Z Nx Ny Nz",
        "%x;y;z;nx;ny;nz",
    ],
)
def test_names_that_programs_write_are_understood(header: str) -> None:
    assert gives(read(text([header, *lines(BALL)])), BALL[:, :3], BALL[:, 3:])


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("start", [0, 1, 17])
def test_an_index_without_a_name_is_ignored(delimiter: str, start: int) -> None:
    rows = [f"{i}{delimiter}{line}" for i, line in enumerate(lines(BALL, delimiter), start)]
    for names in (NAMES, [str(i) for i in range(6)]):
        assert gives(read(text([delimiter.join(["", *names]), *rows])), BALL[:, :3], BALL[:, 3:])


@pytest.mark.parametrize("header", ['"x" "y"', "x y", "   x   y", "0 1", "      0     1"])
@pytest.mark.parametrize("quote", ["", '"'])
def test_the_index_of_a_table_whose_header_is_one_name_shorter_is_ignored(header: str, quote: str) -> None:
    rows = [f"{quote}{i}{quote}  {line}" for i, line in enumerate(lines(OUTLINE, "  "), 1)]
    assert gives(read(text([header, *rows])), OUTLINE)


@pytest.mark.parametrize("count", [2, 3])
def test_pandas_numbers_of_columns_are_no_point(count: int) -> None:
    table = BALL[:, :count]
    assert gives(read(text([",".join(map(str, range(count))), *lines(table)])), table)


def test_whole_numbers_that_look_like_pandas_numbers_are_a_point() -> None:
    assert read("0,1\n4,5\n3,9\n7,2\n").points == 4


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("x,y,z,x,ny,nz", "names x more than once"),
        ("X,Y,Z,nx,ny,NY", "names ny more than once"),
        ("x,y,z,nx,ny,_", "names x, y, z but nx, ny: normals need nx, ny, nz"),
        ("x,y,a,nx,ny,nz", "names x, y but nx, ny, nz: normals need nx, ny"),
        ("a,b,c,d,e,f", "names a, b, c, d, e, f, not x and y"),
        ("x,b,z,d,e,f", "not x and y"),
        ("x,y,z", "line 1 has 3 names, but line 2 has 6 cells"),
        ("x,y,z,nx,ny,nz,i", "line 1 has 7 names, but line 2 has 6 cells"),
    ],
)
def test_a_header_that_does_not_say_what_is_what_is_refused(header: str, says: str) -> None:
    assert says in refused(text([header, *lines(BALL)]))
