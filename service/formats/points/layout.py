"""How a text table is laid out: its delimiter, its header, a count of rows, and the line of the first row.

Comment lines begin with #, // or %. One of them may be the header (`# x y z`, `//X Y Z`). A header without a comment
mark is the first line in which nothing is a number; or `0,1,2`, the numbers that pandas gives to columns without names.
"""

import re
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import count, pairwise

from service.formats.points import columns
from service.formats.points.cells import COMMENT, LONGEST_LINE, MISSING, delimiter, is_number, pieces, split, too_long
from service.jobs.errors import MalformedInputError

# Digits of a count or an index: Python refuses to make an integer of some thousands.
MOST_DIGITS = 18
# Comments before the first row among which names of columns are sought: the last ones, if there are more.
MOST_COMMENTS = 1000


@dataclass(frozen=True)
class Layout:
    """The layout of a table.

    Attributes
    ----------
    delimiter
        The character between cells; None is any run of blanks.
    first_line
        Number of the first row's line, from 1.
    width
        Cells in a row.
    used
        Positions of the cells that can hold values: all but an index without a name in front and, if every row ends in
        a delimiter, the empty cell behind it.
    names
        The header's names of the used cells, or None if there is no header.
    header_line
        Number of the header's line, or 0.
    count, count_line
        The number of rows that a line of its own gives, and that line; None and 0 if there is none.

    """

    delimiter: str | None
    first_line: int
    width: int
    used: tuple[int, ...]
    names: tuple[str, ...] | None = None
    header_line: int = 0
    count: int | None = None
    count_line: int = 0

    @property
    def decimal_comma(self) -> bool:
        """Return whether a comma inside a cell is a decimal point: where the delimiter is another one, and no blank."""
        return self.delimiter in (";", "\t")

    @property
    def trailing(self) -> bool:
        """Return whether every row must end in a delimiter with nothing behind it."""
        return self.used[-1] < self.width - 1


def find(lines: Iterable[str]) -> Layout:
    """Return the layout of a table from its first lines.

    Raises
    ------
    MalformedInputError
        If there is no row, or a line is too long to be one.
    InvalidInputError
        If header and rows do not fit.

    """
    comments: deque[tuple[int, str]] = deque(maxlen=MOST_COMMENTS)
    header: tuple[int, str] | None = None
    rows: list[tuple[int, str]] = []
    counted: tuple[int, str] | None = None
    for number, line in _filled(lines, comments):
        if rows:
            rows.append((number, line))
            break
        if counted is None and re.fullmatch(rf"\s*\d{{1,{MOST_DIGITS}}}\s*", line):
            counted = (number, line)
        elif header is None and _is_header(line):
            header = (number, line)
        else:
            rows.append((number, line))
    if not rows:
        raise MalformedInputError("there is no row of numbers in it", ("points",))
    if header is None and len(rows) == 2 and _is_numbered(rows[0][1], rows[1][1]):
        header, rows = rows[0], rows[1:]
    between = _common_delimiter(rows[0][1], None if header is None else header[1])
    layout = _with_header(_of_row(*rows[0], between), rows, header, comments)
    return layout if counted is None else replace(layout, count=int(counted[1]), count_line=counted[0])


def _filled(lines: Iterable[str], comments: deque[tuple[int, str]]) -> Iterator[tuple[int, str]]:
    """Yield the lines that are not blank, with their numbers from 1; add comments to `comments` instead."""
    for number, line in zip(count(1), lines, strict=False):
        if len(line) > LONGEST_LINE:
            raise too_long(number)
        text = line.strip("\r\n ")
        if text.lstrip().startswith(COMMENT):
            comments.append((number, text.lstrip().lstrip("#/%").strip("\r\n ")))
        elif text.strip():
            yield number, text


def _is_header(line: str) -> bool:
    """Return whether a line names columns: x and y are among them, or nothing in it is a number."""
    words = [piece for piece in pieces(line) if piece.lower() not in MISSING]
    roles = [columns.role(word) for word in words]
    return ("x" in roles and "y" in roles) or (bool(words) and not any(map(is_number, words)))


def _is_numbered(line: str, following: str) -> bool:
    """Return whether a line numbers the columns 0, 1, 2, …, as pandas does for columns without names.

    In front of an index the first name is empty. Without one, 0,1,2 might be a point: it is taken for a header if every
    number below it has a decimal point or an exponent.
    """
    names = pieces(line)
    start = 1 if names[0] == "" else 0
    if len(names) - start < 2 or names[start:] != [str(i) for i in range(len(names) - start)]:
        return False
    below = [piece for piece in pieces(following) if piece] or ["-"]
    if start or len(below) == len(names) + 1:
        return below[0].isdecimal()
    return all(re.search(r"[.eE]", piece) for piece in below)


def _common_delimiter(row: str, header: str | None) -> str | None:
    """Return the delimiter of the header, if it splits the row into as many cells, else the row's own.

    A label in the row may hold other delimiters; a header often has blanks where rows have commas.
    """
    if header is not None:
        between = delimiter(header)
        if len(split(row, between)) == len(split(header, between)):
            return between
    return delimiter(row)


def _of_row(first_line: int, row: str, between: str | None) -> Layout:
    """Return the layout of a table without a header, from its first row."""
    cells = split(row, between)
    trailing = between is not None and len(cells) > 2 and cells[-1] == ""
    return Layout(between, first_line, len(cells), tuple(range(len(cells) - trailing)))


def _with_header(
    layout: Layout, rows: list[tuple[int, str]], header: tuple[int, str] | None, comments: Iterable[tuple[int, str]]
) -> Layout:
    """Return the layout with the names that a header, or a comment that names x and y, gives to its columns."""
    if header is None:
        named = [(number, text) for number, text in comments if _names_points(text) and number < layout.first_line]
        fitting = [layout_ for number, text in named if (layout_ := _named(layout, rows, number, text)) is not None]
        return fitting[-1] if fitting else layout
    found = _named(layout, rows, *header)
    if found is None:
        names = len(split(header[1], delimiter(header[1])))
        raise MalformedInputError(
            f"line {header[0]} has {names} names, but line {layout.first_line} has {layout.width} cells", ("points",)
        )
    return found


def _names_points(text: str) -> bool:
    roles = [columns.role(piece) for piece in pieces(text)]
    return "x" in roles and "y" in roles


def _named(layout: Layout, rows: list[tuple[int, str]], number: int, text: str) -> Layout | None:
    """Return the layout with the names in a header, or None if there are not as many names as columns.

    One name less than there are cells leaves out the name of an index in front, or of nothing behind a last delimiter.
    """
    for between in dict.fromkeys((layout.delimiter, delimiter(text))):
        names = tuple(split(text, between))
        if names[:1] == ("",) and between is None:
            names = names[1:]
        if len(names) == layout.width:
            used = tuple(range(layout.width))
            break
        if len(names) == len(layout.used):
            used = layout.used
            break
        if len(names) == layout.width - 1 and _has_index([split(row, layout.delimiter)[0] for _, row in rows]):
            used = tuple(range(1, layout.width))
            break
    else:
        return None
    if all(name == "" or name.isdecimal() for name in names):  # pandas' numbers: the columns have no names
        used = used[1:] if names[0] == "" else used
        return replace(layout, used=used, header_line=number)
    return replace(layout, used=used, names=names, header_line=number)


def _has_index(cells: list[str]) -> bool:
    """Return whether these first cells of rows are an index: whole numbers that count up, or no numbers at all."""
    if not any(map(is_number, cells)):
        return True
    bare = [cell.strip('"') for cell in cells]
    if not all(cell.isdecimal() and len(cell) <= MOST_DIGITS for cell in bare):
        return False
    return all(int(b) == int(a) + 1 for a, b in pairwise(bare))
