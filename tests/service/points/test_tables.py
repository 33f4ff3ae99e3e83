"""Rows of text tables: in every layout that programs write, with missing values and wrong ones."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.formats.points import decode
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from service.jobs.media_types import Missing  # noqa: TC001 - no block of imports for one annotation
from tests.service.points.tables import BALL, NAMES, OUTLINE, QUICK, gives, lines, read, refused, text

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
    header: bool,
    end: str,
    mark: bool,
    last: bool,
    indent: bool,
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


@pytest.mark.parametrize("digits", [19, 4301, 60_000])
def test_a_number_of_too_many_digits_is_no_count_and_no_index(digits: int) -> None:
    rows, long = lines(OUTLINE), "9" * digits
    with pytest.raises((InvalidInputError, MalformedInputError)):
        read(text([long, *rows]))
    with pytest.raises((InvalidInputError, MalformedInputError)):
        read(text(["x,y", f"{long},{rows[0]}", f"{long},{rows[1]}"]))


# Missing and wrong values


@pytest.mark.parametrize("cell", ["", " ", "nan", "NaN", "NA", "n/a", "null", "None", "-", "inf", "-Infinity", "1e999"])
@pytest.mark.parametrize("row", [0, 3, 19])
@pytest.mark.parametrize("header", [True, False])
def test_a_missing_value_is_refused_with_its_line_or_left_out(cell: str, row: int, header: bool) -> None:
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
