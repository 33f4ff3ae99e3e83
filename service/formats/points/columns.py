"""Which column of a table holds what.

In this order:

1. The caller's option `columns` decides.
2. Else names decide: a header, or the field names of a structured array.
3. Else two or three columns are points; four (2D) or six (3D) are points and normals when the second half has unit
   length within 10 %; in an array, whose format says that they are points and normals, one length of any size. Whole
   numbers from 0 to 255 in the second half are colours, not normals.
4. Anything else is refused with a message that says what to write for `columns`.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from service.formats.points.reading import Array, shortened
from service.jobs.errors import InvalidInputError

COORDINATES = ("x", "y", "z")
NORMALS = ("nx", "ny", "nz")
ROLES = (*COORDINATES, *NORMALS)
IGNORED = "_"
# How far the length of a normal may be from 1 before unnamed columns are not taken for normals: files with three
# decimals are within 0.1 %, while intensities, colours and coordinates are rarely within 10 % in every row.
LENGTH_TOLERANCE = 0.1
# Vectors whose mean is longer than this share of their length point in about one direction.
ONE_DIRECTION = 0.9
# A name with everything but letters and digits left out, in lower case → its role. `points0` is what ParaView writes.
_ROLE_OF = {
    **{role: role for role in ROLES},
    **{f"normal{axis}": f"n{axis}" for axis in COORDINATES},
    **{f"normals{axis}": f"n{axis}" for axis in COORDINATES},
    **{f"points{i}": axis for i, axis in enumerate(COORDINATES)},
    **{f"normals{i}": f"n{axis}" for i, axis in enumerate(COORDINATES)},
}
_UNIT = re.compile(r"[(\[].*[)\]]\s*$")
MOST_IN_EXAMPLE = 50  # columns; more would make a message of which nothing is read
EXAMPLES = {
    2: "x,y",
    3: "x,y,_ or columns=x,y,z",
    4: "x,y,z,_ or columns=x,y,nx,ny",
    5: "x,y,z,_,_ or columns=x,y,nx,ny,_",
    6: "x,y,z,nx,ny,nz or columns=x,y,z,_,_,_",
}


@dataclass(frozen=True)
class Columns:
    """The positions of the points' columns and of the normals' columns in a table.

    Attributes
    ----------
    points
        Positions of x, y and perhaps z, from 0.
    normals
        Positions of nx, ny and perhaps nz; empty if there are none.

    """

    points: tuple[int, ...]
    normals: tuple[int, ...] = ()

    def split(self, table: Array) -> tuple[Array, Array | None]:
        """Return the points (N, d) and the normals (N, d), or None, of a table (N, columns)."""
        return table[:, self.points], table[:, self.normals] if self.normals else None


def role(name: str) -> str | None:
    """Return what a column of this name holds, or None if it is to be ignored.

    >>> [role(name) for name in ("X", "y [mm]", "Normal_Z", "Points:0", "intensity", "")]
    ['x', 'y', 'nz', 'x', None, None]
    """
    return _ROLE_OF.get(re.sub(r"[\W_]", "", _UNIT.sub("", name)).lower())


def parse(text: str) -> tuple[str, ...]:
    """Return the roles that the option `columns` names.

    >>> parse("x, y, nx, ny, _")
    ('x', 'y', 'nx', 'ny', '_')

    Raises
    ------
    InvalidInputError
        If a name is none of x, y, z, nx, ny, nz and _.

    """
    roles = tuple(name.strip().lower() for name in text.split(","))
    unknown = next((name for name in roles if name not in (*ROLES, IGNORED)), None)
    if unknown is not None:
        raise InvalidInputError(
            f"columns has {shortened(unknown)!r}; known are {', '.join(ROLES)}, and {IGNORED} for a column to ignore, "
            "as in columns=x,y,z,_",
            ("columns",),
        )
    return roles


def chosen(roles: Sequence[str], width: int) -> Columns:
    """Return the columns that the caller chose for a table of this many columns.

    Raises
    ------
    InvalidInputError
        If there are more or fewer names than columns, or the names do not make points.

    """
    if len(roles) != width:
        raise InvalidInputError(
            f"columns names {len(roles)} columns, but there are {width}: name each, {IGNORED} for one to ignore",
            ("columns",),
        )
    found = named(roles, "columns")
    if found is None:
        raise InvalidInputError("columns must name x and y, as in columns=x,y", ("columns",))
    return found


def named(roles: Sequence[str | None], source: str) -> Columns | None:
    """Return the columns that these roles make, or None if x or y is not among them.

    Raises
    ------
    InvalidInputError
        If a role occurs twice, or the normals have other axes than the points. The message begins with `source`, which
        says where the names stand.

    """
    twice = next((name for name in ROLES if roles.count(name) > 1), None)
    if twice is not None:
        raise InvalidInputError(f"{source} names {twice} more than once: {_advice(len(roles))}", ("columns",))
    if "x" not in roles or "y" not in roles:
        return None
    dimension = 3 if "z" in roles else 2
    normals = tuple(name for name in NORMALS if name in roles)
    if normals not in ((), NORMALS[:dimension]):
        raise InvalidInputError(
            f"{source} names {', '.join(COORDINATES[:dimension])} but {', '.join(normals)}: normals need "
            f"{', '.join(NORMALS[:dimension])}; {_advice(len(roles))}",
            ("columns",),
        )
    return Columns(
        tuple(roles.index(name) for name in COORDINATES[:dimension]), tuple(roles.index(name) for name in normals)
    )


def from_names(names: Sequence[str], source: str) -> Columns:
    """Return the columns that a header names.

    Raises
    ------
    InvalidInputError
        If it does not name x and y.

    """
    found = named([role(name) for name in names], source)
    if found is None:
        listed = shortened(", ".join(names) or "nothing", 80)
        raise InvalidInputError(f"{source} names {listed}, not x and y: {_advice(len(names))}", ("columns",))
    return found


def check_width(width: int) -> None:
    """Refuse a number of columns of which nobody can say without names what they are.

    Raises
    ------
    InvalidInputError
        Unless there are 2, 3, 4 or 6.

    """
    if width not in (2, 3, 4, 6):
        raise InvalidInputError(
            f"{width} columns without names: 2 or 3 are points, 4 or 6 may be points and normals; {_advice(width)}",
            ("points",),
        )


def from_values(table: Array, *, unit: bool = True) -> Columns:
    """Return the columns of a table (N, columns) without names; `unit` says that normals must have length 1.

    Raises
    ------
    InvalidInputError
        If it cannot be told what they are.

    """
    width = table.shape[1]
    check_width(width)
    if width in (2, 3):
        return Columns(tuple(range(width)))
    half = width // 2
    _check_normals(table[:, half:], width, unit=unit)
    return Columns(tuple(range(half)), tuple(range(half, width)))


def _check_normals(normals: Array, width: int, *, unit: bool) -> None:
    """Refuse the second half (N, d) of a table without names unless its rows are normals."""
    complete = normals[np.isfinite(normals).all(axis=1)]
    first = width // 2 + 1
    length = _lengths(complete)
    if not len(complete) or np.abs(length - 1.0).max() <= LENGTH_TOLERANCE:
        return
    if ((complete == np.round(complete)) & (complete >= 0) & (complete <= 255)).all():
        raise InvalidInputError(
            f"columns {first} to {width} hold whole numbers from 0 to 255, as colours do, and have no names: "
            + _advice(width),
            ("columns",),
        )
    if unit or not _have_one_length(complete, length):
        wanted = "1" if unit else "1, or one in many directions"
        raise InvalidInputError(
            f"{width} columns without names: columns {first} to {width} are not normals, whose length would be "
            f"{wanted}, not {length.min():.4g} to {length.max():.4g}; {_advice(width)}",
            ("columns",),
        )


def _lengths(vectors: Array) -> Array:
    """Return the lengths (N,) of vectors (N, d)."""
    largest = float(np.abs(vectors).max(initial=0.0)) or 1.0  # divided out, so that no square over- or underflows
    with np.errstate(over="ignore"):  # the length of the largest numbers is infinite, which no normal has
        return np.asarray(largest * np.linalg.norm(vectors / largest, axis=1))


def _have_one_length(vectors: Array, length: Array) -> bool:
    """Return whether vectors (N, d) of these lengths (N,) may be normals: of one length, in many directions.

    Not all in one direction, as z beside a constant.
    """
    usual = float(np.median(length))
    if not 0.0 < usual < np.inf or np.abs(length - usual).max() > LENGTH_TOLERANCE * usual:
        return False
    return float(np.linalg.norm((vectors / usual).mean(axis=0))) < ONE_DIRECTION


def _advice(width: int) -> str:
    """Return what to write for `columns` with this many columns."""
    if width < 2:
        return "points need at least two columns, x and y"
    example = EXAMPLES.get(width, ",".join((*ROLES, *[IGNORED] * (min(width, MOST_IN_EXAMPLE) - 6))))
    return f"say which is which, for example columns={example} ({IGNORED} ignores a column)"
