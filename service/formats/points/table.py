"""Text tables: csv, tsv, txt, xyz, asc.

The standard library's csv module splits lines into cells, `float` reads the cells, and this module keeps the number of
each row's line, so that a refused line is named by its number in the file. Readers were compared on 1,000,000 rows of
6 numbers (57 MB), on two cores that others kept busy:

============= ======= =================== ====================================================================
reader        seconds size of its wheel   a missing cell, and a line with a cell too few
============= ======= =================== ====================================================================
csv + float   2.8     none                the line's number is ours to keep
numpy.loadtxt 1.9     none                named by the row without comments and blank lines; columns that are
                                          left out may be of any number, so that ragged lines pass unnoticed
pyarrow.csv   0.7     55 MB               missing is null; ragged is refused with the line's text, no number
polars        0.6     54 MB               both are null
============= ======= =================== ====================================================================

The standard library is fast enough beside a fit of so many points, and is the only one that says in which line of the
file a value is wrong. On an idle machine it reads a million such rows in about 1 s.
"""

from collections.abc import Sequence
from io import BytesIO, TextIOWrapper
from typing import TextIO

import numpy as np

from service.formats.points import columns, layout
from service.formats.points.columns import Columns
from service.formats.points.layout import Layout
from service.formats.points.reading import Array, RawPoints, ReadOptions
from service.formats.points.table_rows import TableRows
from service.jobs.errors import InvalidInputError

_UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def read_table(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the points of a text table.

    Raises
    ------
    MalformedInputError
        If a line is not a row of this table; its number is named.
    InvalidInputError
        If it cannot be told which column is what; `columns` settles it.
    TooLargeError
        If there are more than `max_points` rows.

    """
    if content.startswith(_UTF_16):
        content = content.decode("utf-16", errors="replace").encode()
    found = layout.find(_lines(content))
    given = _columns(found, options.columns)
    wanted = found.used if given is None else (*given.points, *given.normals)
    labels = [_label(given, position) for position in wanted]
    rows = TableRows(found, wanted, labels, options)
    rows.read(_lines(content.replace(b",", b".") if found.decimal_comma else content))
    points, normals = _split(rows, given)
    if options.missing == "refuse":
        _refuse_missing(rows, normals)
    return RawPoints(points, normals)


def _lines(content: bytes) -> TextIO:
    """Return the text line by line. What is not UTF-8 becomes U+FFFD: in a comment or a label it does no harm."""
    return TextIOWrapper(BytesIO(content), encoding="utf-8-sig", errors="replace")


def _columns(found: Layout, option: tuple[str, ...] | None) -> Columns | None:
    """Return the columns that the option or the header names, or None if the values must decide."""
    if option is not None:
        used = found.used if len(option) == len(found.used) else tuple(range(found.width))
        return _moved(columns.chosen(option, len(used)), used)
    if found.names is not None:
        return _moved(columns.from_names(found.names, f"the header in line {found.header_line}"), found.used)
    columns.check_width(len(found.used))
    return None


def _moved(given: Columns, used: Sequence[int]) -> Columns:
    """Return columns whose positions count the used cells only as positions in the whole row."""
    return Columns(tuple(used[i] for i in given.points), tuple(used[i] for i in given.normals))


def _label(given: Columns | None, position: int) -> str:
    """Return how a message calls the cell at this position of a row, and what it holds if that is known."""
    if given is None:
        return f"column {position + 1}"
    roles = (*columns.COORDINATES[: len(given.points)], *columns.NORMALS)
    return f"column {position + 1} ({roles[(*given.points, *given.normals).index(position)]})"


def _split(rows: TableRows, given: Columns | None) -> tuple[Array, Array | None]:
    """Return points (N, d) and normals (N, d), or None."""
    table = rows.table
    if given is None:
        return columns.from_values(table).split(table)
    d = len(given.points)
    return table[:, :d], table[:, d:] if given.normals else None


def _refuse_missing(rows: TableRows, normals: Array | None) -> None:
    """Refuse a value that is not finite, or a normal of length 0, with the number of its line."""
    bad = np.argwhere(~np.isfinite(rows.table))
    if len(bad):
        row, column = map(int, bad[0])
        value = rows.table[row, column]
        raise rows.refused(row, column, f"is {value}, not a finite number", missing=True)
    if normals is not None and not normals.any(axis=1).all():
        zero = np.flatnonzero(~normals.any(axis=1))
        row = int(zero[0])
        raise InvalidInputError(
            f"line {rows.numbers[row]}: the normal has length 0 ({len(zero)} in all); missing=drop leaves such points "
            "out",
            ("normals", row),
        )
