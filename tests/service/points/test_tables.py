"""Text tables: which column is what, in every layout that programs write."""

import csv
from io import StringIO
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.formats.points import decode
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from service.jobs.fit import PointSet
from service.jobs.media_types import Missing
from tests.service.bodies import Array, ellipse, sphere

BALL = sphere(30)
OUTLINE = ellipse(20)
NAMES = ("x", "y", "z", "nx", "ny", "nz")
QUICK = settings(deadline=None, max_examples=60)


def read(text: str | bytes, columns: str | None = None, missing: Missing = "refuse", most: int = 1000) -> PointSet:
    content = text if isinstance(text, bytes) else text.encode()
    return decode.read(content, "csv", most, columns=columns, missing=missing)


def refused(text: str | bytes, columns: str | None = None, missing: Missing = "refuse") -> str:
    with pytest.raises(InvalidInputError) as caught:
        read(text, columns, missing)
    return str(caught.value)


def lines(table: Array, delimiter: str = ",", decimal: str = ".") -> list[str]:
    return [delimiter.join(repr(float(value)).replace(".", decimal) for value in row) for row in table]


def text(rows: list[str], end: str = "\n") -> str:
    return "".join(row + end for row in rows)


def gives(found: PointSet, points: Array, normals: Array | None = None) -> bool:
    x, n = decode.split(found.content, found.dimension)
    if (n is None) != (normals is None):
        return False
    return np.array_equal(x, points) and (n is None or normals is None or np.allclose(n, normals, atol=1e-15))


# Headers


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


# The option


@QUICK
@given(order=st.permutations(range(8)), header=st.booleans())
def test_columns_decides_whatever_the_header_says(order: list[int], header: bool) -> None:  # noqa: FBT001 - drawn
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


# Delimiters and numbers


@QUICK
@given(
    delimiter=st.sampled_from([",", ", ", " ,", ";", " ; ", "\t", " ", "     ", ",\t"]),
    header=st.booleans(),
    end=st.sampled_from(["\n", "\r\n", "\r", "\n\n"]),
    mark=st.booleans(),
    last=st.booleans(),
    indent=st.booleans(),
)
def test_any_delimiter_and_line_end_is_read(  # noqa: PLR0913, PLR0917 - drawn
    delimiter: str,
    header: bool,  # noqa: FBT001
    end: str,
    mark: bool,  # noqa: FBT001
    last: bool,  # noqa: FBT001
    indent: bool,  # noqa: FBT001
) -> None:
    rows = [delimiter.join(NAMES[:3])] if header else []
    rows += lines(BALL[:, :3], delimiter)
    if indent and delimiter.strip() != "":
        rows = ["  " + row for row in rows]
    content = text(rows, end)
    content = content if last else content.rstrip("\r\n")
    assert gives(read((b"\xef\xbb\xbf" if mark else b"") + content.encode()), BALL[:, :3])


@pytest.mark.parametrize("delimiter", [";", "; ", "\t"])
@pytest.mark.parametrize("header", ["", "x{0}y", '"x"{0}"y"', "# x{0}y"])
def test_a_decimal_comma_is_one_between_semicolons_or_tabs(delimiter: str, header: str) -> None:
    rows = [header.format(delimiter)] if header else []
    assert gives(read(text([*rows, *lines(OUTLINE, delimiter, ",")])), OUTLINE)
    assert gives(read(text([*rows, *lines(OUTLINE, delimiter, ".")])), OUTLINE)


@pytest.mark.parametrize("row", ["1,5 2,5", "1.000,5;2", "1,2,3;4", "1;2;", "1,,2;3", "0x10,2", "1 2,3 4"])
def test_what_is_no_number_between_these_delimiters_is_refused(row: str) -> None:
    assert "line" in refused(text([row, *lines(OUTLINE, ";" if ";" in row else ",")]))


def test_a_delimiter_at_the_end_of_every_line_ends_no_column() -> None:
    assert gives(read(text([line + ";" for line in lines(BALL[:, :3], ";")])), BALL[:, :3])
    rows = [line + "," for line in lines(BALL[:, :3])]
    assert gives(read(text(["x,y,z", *rows])), BALL[:, :3])
    assert gives(read(text(["x,y,z,", *rows])), BALL[:, :3])
    assert "line 8 has a value after its last delimiter" in refused(text([*rows[:7], "1,2,3,4", *rows[7:]]))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "latin-1"])
def test_encodings(encoding: str) -> None:
    content = ("﻿" if encoding == "utf-16-le" else "") + text(["# Größe", "x;y;name", *lines(OUTLINE, ";"), ""])
    content = content.replace("\n\n", "\n").replace("x;y;name", "x;y")
    assert gives(read(content.encode(encoding)), OUTLINE)


# Comments, counts


@pytest.mark.parametrize("mark", ["#", "# ", "//", "%", "  # ", "## "])
def test_comments_and_blank_lines_stand_anywhere(mark: str) -> None:
    rows = lines(BALL[:, :3])
    rows = [f"{mark}x", "", *rows[:7], "  ", f'{mark}, "1,2,3', *rows[7:], f"{mark}1,2,3", ""]
    assert gives(read(text(rows)), BALL[:, :3])


def test_a_row_that_is_commented_out_is_no_row_even_where_its_first_column_is_ignored() -> None:
    rows = [f"{i},{line}" for i, line in enumerate(lines(OUTLINE))]
    assert read(text([*rows[:5], "#" + rows[5], *rows[6:]]), columns="_,x,y").points == 19


@pytest.mark.parametrize("before", [[], ["//X Y Z"], ["# c", ""], ["x y z"]])
@pytest.mark.parametrize("after", [[], ["x y z"], ["", "# c"]])
def test_a_count_before_the_rows_is_accepted_and_must_be_right(before: list[str], after: list[str]) -> None:
    if "x y z" in before and "x y z" in after:
        return
    rows = lines(BALL[:, :3], " ")
    assert gives(read(text([*before, "30", *after, *rows])), BALL[:, :3])
    message = refused(text([*before, "31", *after, *rows]))
    assert f"line {len(before) + 1} says 31 rows, but there are 30" in message


# Missing and wrong values


@pytest.mark.parametrize("cell", ["", " ", "nan", "NaN", "NA", "n/a", "null", "None", "-", "inf", "-Infinity", "1e999"])
@pytest.mark.parametrize("row", [0, 3, 19])
@pytest.mark.parametrize("header", [True, False])
def test_a_missing_value_is_refused_with_its_line_or_left_out(cell: str, row: int, header: bool) -> None:  # noqa: FBT001
    rows = lines(OUTLINE)
    rows[row] = rows[row].split(",")[0] + "," + cell
    if cell.strip() == "" and row == 0 and not header:
        rows.reverse()  # at the end of the first line it might be no column
        row = 19
    rows = (["# a comment", "", "x,y"] if header else []) + rows
    message = refused(text(rows))
    assert f"line {row + 1 + 3 * header}, column 2" in message
    assert "missing=drop" in message
    found = read(text(rows), missing="drop")
    assert (found.points, found.left_out) == (19, 1)


@pytest.mark.parametrize("cell", ["two", "1.2.3", "1e", "--1", "1 2", "½", "x" * 1000])
def test_what_is_no_number_is_refused_even_if_missing_values_are_left_out(cell: str) -> None:
    rows = lines(OUTLINE)
    rows[7] = f"1.5,{cell}"
    both: list[Missing] = ["refuse", "drop"]
    for missing in both:
        message = refused(text(["x,y", *rows]), missing=missing)
        assert "line 9, column 2 (y) is not a number" in message
        assert len(message) < 200


@pytest.mark.parametrize("row", ["1", "1,2,3", "1,2,", ",,", "1,2,3,4,5,6,7"])
@pytest.mark.parametrize("place", [1, 10, 20])
def test_a_ragged_line_is_refused_with_its_number(row: str, place: int) -> None:
    rows = lines(OUTLINE)
    message = refused(text(["", *rows[:place], row, *rows[place:]]))
    assert f"line {place + 2} has" in message


def test_a_ragged_line_is_refused_even_where_the_columns_that_are_read_are_there() -> None:
    rows = lines(BALL)
    rows[4] += ",5"
    assert "line 5 has 7 cells, but line 1 has 6" in refused(text(rows), columns="x,y,z,_,_,_")


def test_a_line_deep_in_a_long_table_is_named() -> None:
    rows = lines(huge := np.tile(OUTLINE, (700, 1)))
    rows[9999] = "1.0,"
    with pytest.raises(InvalidInputError, match=r"line 10000, column 2 is missing"):
        read(text(rows), most=20_000)
    assert read(text(rows), missing="drop", most=20_000).points == len(huge) - 1


def test_a_normal_of_length_zero_is_refused_with_its_line_or_left_out() -> None:
    table = BALL.copy()
    table[9, 3:] = 0.0
    content = text([",".join(NAMES), *lines(table)])
    assert "line 11: the normal has length 0 (1 in all); missing=drop" in refused(content)
    assert read(content, missing="drop").left_out == 1


def test_a_table_of_which_nothing_is_left_says_so() -> None:
    assert "none is left" in refused("x,y\nnan,1\nnan,2\n", missing="drop")


@pytest.mark.parametrize("content", ["", "\n\n", "# nothing", "x,y\n", "3\n", "﻿", "#x\n//y\n"])
def test_a_table_without_rows_says_so(content: str) -> None:
    assert "no row of numbers" in refused(content)


def test_more_rows_than_may_be_are_too_large() -> None:
    with pytest.raises(TooLargeError):
        read(text(lines(OUTLINE)), most=19)


@pytest.mark.parametrize("content", ["1," * 40_000, text(lines(OUTLINE)) + "1," * 40_000])
def test_a_line_without_end_is_refused(content: str) -> None:
    with pytest.raises(MalformedInputError, match=r"line (1|21) has more than 65536 characters"):
        read(content)


@pytest.mark.parametrize("order", list(permutations(range(3)))[:5])
def test_the_five_endings_are_read_alike(order: tuple[int, ...]) -> None:
    content = text([" ".join(NAMES[i] for i in order), *lines(BALL[:, order], " ")]).encode()
    for kind in ("csv", "tsv", "txt", "xyz", "asc"):
        assert gives(decode.read(content, kind, 1000), BALL[:, :3])
