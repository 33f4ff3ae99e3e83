"""The cells of one line of a text table."""

import csv
import re

from service.jobs.errors import MalformedInputError

COMMENT = ("#", "//", "%")
LONGEST_LINE = 65_536  # characters; a row of six numbers has about 150
# What programs write where a number is missing, in lower case; all but the empty cell and nan are refused by `float`.
MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "-nan", "-nan(ind)", "1.#qnan", "-1.#ind", "-"})
_QUOTED = re.compile(r'"[^"]*"')


def delimiter(line: str) -> str | None:
    r"""Return what stands between the cells of a line; None is any run of blanks.

    >>> [delimiter(line) for line in ("12,5;3,1", "1.0,2.0", "1.0, 2.0", "1,5\t2,5", "1 2")]
    [';', ',', ',', '\t', None]
    """
    line = _QUOTED.sub('""', line)
    if ";" in line:
        return ";"
    if "\t" in line:
        cells = line.split("\t")
        if all(cell.rstrip().endswith(",") for cell in cells[:-1]):
            return ","
        return None if any(re.search(r"\S +\S", cell) for cell in cells) and "," not in line else "\t"
    return "," if "," in line else None


def split(line: str, between: str | None) -> list[str]:
    """Return the cells of one line, without quotation marks and the blanks around them.

    >>> split('"1.5" ; 2', ";")
    ['1.5', '2']
    """
    if between is None:
        return [cell.strip('"') for cell in line.split()]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=between, skipinitialspace=True))]


def pieces(line: str) -> list[str]:
    """Return what stands between delimiters of any kind."""
    return [piece.strip('"') for piece in re.split(r"[,;\t]|[ ]+", line)]


def is_number(cell: str) -> bool:
    """Return whether a cell holds a number, with a decimal point or a decimal comma."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def too_long(line: int) -> MalformedInputError:
    """Return the error for a line that is too long."""
    return MalformedInputError(f"line {line} has more than {LONGEST_LINE} characters", ("points",))
