"""The rows of a text table: from lines to numbers.

Lines are read in blocks. A block whose lines are all rows of numbers, which nearly every block is, goes through the csv
module and `float` at once; the lines of any other block are read one by one, to find the one that is wrong.
"""

import csv
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, islice
from operator import itemgetter
from typing import TextIO

import numpy as np

from service.formats.points.cells import COMMENT, LONGEST_LINE, MISSING, split, too_long
from service.formats.points.layout import Layout
from service.formats.points.reading import Array, ReadOptions, check_count, shortened
from service.jobs.errors import InvalidInputError, MalformedInputError

# Lines that are read at once: enough that the work per block does not show, few enough that the lines take no memory.
BLOCK_LINES = 4096


@dataclass
class TableRows:
    """The rows of a table as they are read.

    Attributes
    ----------
    layout
        Of the table.
    wanted
        Positions of the cells to read.
    labels
        What messages call them.
    options
        How to read.
    blocks
        The numbers of the wanted cells of some rows after others, (rows, cells) each.
    numbers
        The number of each row's line.

    """

    layout: Layout
    wanted: Sequence[int]
    labels: Sequence[str]
    options: ReadOptions
    blocks: list[Array] = field(default_factory=list)
    numbers: "array[int]" = field(default_factory=lambda: array("q"))

    @property
    def dimension(self) -> int:
        """Return how many of the wanted columns are points'."""
        return len(self.wanted) // 2 if len(self.wanted) > 3 else len(self.wanted)

    @cached_property
    def table(self) -> Array:
        """The numbers of all rows, (N, wanted cells); there is at least one row."""
        return np.concatenate(self.blocks)

    def read(self, lines: TextIO) -> None:
        """Read all rows, and compare their number with the count in the file, if there is one."""
        skipped = self.layout.first_line - 1
        for number, block in _blocks(lines, skipped + 1):
            if not self._read_block(number, block):
                self._read_lines(number, block)
            check_count(len(self.numbers), self.options.max_points)
        expected = self.layout.count
        if expected is not None and expected != len(self.numbers):
            raise MalformedInputError(
                f"line {self.layout.count_line} says {expected} rows, but there are {len(self.numbers)}", ("points",)
            )

    def _read_block(self, number: int, block: list[str]) -> bool:
        """Read lines that are all rows of numbers; return whether they were."""
        starts = set(map(itemgetter(0), block))
        if starts & {" ", "\t"}:
            starts = {line.lstrip()[:1] for line in block}
        if self.layout.trailing or starts & {"#", "/", "%", "\n", ""}:
            return False
        try:
            rows = list(_cells(block, self.layout.delimiter))
            if len(rows) == len(block) and set(map(len, rows)) == {self.layout.width}:
                self._add(list(map(float, chain.from_iterable(map(itemgetter(*self.wanted), rows)))))
                self.numbers.extend(range(number, number + len(block)))
                return True
        except (ValueError, csv.Error):
            pass  # a line is not a row of numbers: which, and whether it may be so, is seen when they are read singly
        return False

    def _add(self, values: list[float]) -> None:
        self.blocks.append(np.array(values, dtype=np.float64).reshape(-1, len(self.wanted)))

    def _read_lines(self, first: int, block: list[str]) -> None:
        """Read lines one by one: pass over comments and blank lines, and name the first line that is wrong."""
        values: list[float] = []
        for number, line in enumerate(block, first):
            if line.isspace() or line.lstrip().startswith(COMMENT):
                continue
            cells = split(line.strip("\r\n "), self.layout.delimiter)
            self.numbers.append(number)
            self._check_width(cells)
            row = len(self.numbers) - 1
            values.extend(self._number(row, i, cells[position]) for i, position in enumerate(self.wanted))
        self._add(values)

    def _check_width(self, cells: list[str]) -> None:
        line, row, width = self.numbers[-1], len(self.numbers) - 1, self.layout.width
        if len(cells) != width:
            raise MalformedInputError(
                f"line {line} has {len(cells)} cells, but line {self.layout.first_line} has {width}", ("points", row)
            )
        if self.layout.trailing and cells[-1] != "":
            raise MalformedInputError(
                f"line {line} has a value after its last delimiter, where line {self.layout.first_line} has none",
                ("points", row),
            )

    def _number(self, row: int, column: int, cell: str) -> float:
        try:
            return float(cell)
        except ValueError:
            pass
        if cell.lower() not in MISSING:
            raise self.refused(row, column, f"is not a number: {shortened(cell)!r}")
        if self.options.missing == "refuse":
            raise self.refused(row, column, "is missing", missing=True)
        return float("nan")

    def refused(self, row: int, column: int, problem: str, *, missing: bool = False) -> InvalidInputError:
        """Return the error for the value in a wanted column of a row, and how to read the table all the same."""
        kind = InvalidInputError if missing else MalformedInputError
        remedy = "missing=drop leaves such lines out" if missing else "columns=… with _ ignores a column"
        at = ("points", row, column) if column < self.dimension else ("normals", row, column - self.dimension)
        return kind(f"line {self.numbers[row]}, {self.labels[column]} {problem}; {remedy}", at)


def _cells(lines: list[str], between: str | None) -> Iterator[list[str]]:
    """Return the cells of each line; a quoted cell that runs over several lines makes fewer rows than lines."""
    if between is None:
        return map(str.split, lines)
    return csv.reader(lines, delimiter=between, skipinitialspace=True)


def _blocks(lines: TextIO, first: int) -> Iterator[tuple[int, list[str]]]:
    """Yield the lines from number `first` on in blocks, each with the number of its first line."""
    number = first
    rest = islice(lines, first - 1, None)
    while block := list(islice(rest, BLOCK_LINES)):
        if max(map(len, block)) > LONGEST_LINE:
            raise too_long(next(number + i for i, line in enumerate(block) if len(line) > LONGEST_LINE))
        yield number, block
        number += len(block)
