"""The version of a database's tables, written in the database itself, and the steps from each version to the next.

A version is the name of the last step that was made. Alembic would do the same for many tables and branches of history;
here are two parts, one of which (the queue's tables) comes with its own steps as plain SQL.
"""

from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import dataclass

from sqlalchemy import Column, Connection, Engine, MetaData, String, Table, inspect, select, text

_versions = Table(
    "ipfit_versions", MetaData(), Column("part", String, primary_key=True), Column("version", String, nullable=False)
)
# Any number, the same in every process: whoever holds this lock prepares the database.
_PREPARING = 4_711_001


class DatabaseVersionError(Exception):
    """The database was made by another version of this program, which knows what this one does not."""


@dataclass(frozen=True)
class Part:
    """Tables that get their versions together.

    Attributes
    ----------
    name
        Under which their version is kept.
    table
        One that is there when they are.
    make
        Makes them, as they are after the last step.
    steps
        Name and SQL of each step, the oldest first. The first is only a name, that of the tables as they once began.
    columns
        What `table` must have in the end.

    """

    name: str
    table: str
    make: Callable[[Connection], object]
    steps: dict[str, str]
    columns: frozenset[str] = frozenset()


def prepare(engine: Engine, parts: Iterable[Part]) -> None:
    """Make the tables that are not there, and bring older ones up to date, in one transaction.

    Raises
    ------
    DatabaseVersionError
        If the database is of a later version, or nobody knows of which.

    """
    with engine.begin() as connection:
        if engine.dialect.name == "sqlite":
            connection.exec_driver_sql("BEGIN IMMEDIATE")  # the driver itself begins with the first INSERT only
        else:
            connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": _PREPARING})
        _versions.create(connection, checkfirst=True)
        for part in parts:
            _bring(connection, part)


def _bring(connection: Connection, part: Part) -> None:
    query = select(_versions.c.version).where(_versions.c.part == part.name)
    kept, newest = connection.execute(query).scalar(), list(part.steps)[-1]
    if kept is None:  # made before versions were written down, or not made yet
        if not inspect(connection).has_table(part.table):
            part.make(connection)
        connection.execute(_versions.insert().values(part=part.name, version=newest))
    elif kept != newest:
        for step in _steps_after(kept, part):
            with closing(connection.connection.cursor()) as cursor:  # the driver's own, to which a % is just that
                cursor.execute(part.steps[step])
        connection.execute(_versions.update().where(_versions.c.part == part.name).values(version=newest))
    there = {column["name"] for column in inspect(connection).get_columns(part.table)}
    if missing := sorted(part.columns - there):
        raise DatabaseVersionError(f"the table {part.table} has no {', '.join(missing)}: an unreleased ipfit made it")


def _steps_after(version: str, part: Part) -> list[str]:
    names = list(part.steps)
    if version not in names:
        raise DatabaseVersionError(
            f"the tables of {part.name} are of version {version}, which this ipfit does not know; its last is "
            f"{names[-1]}. A newer ipfit made or changed them: use that one"
        )
    return names[names.index(version) + 1 :]
