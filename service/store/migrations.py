"""The version of the tables, stored in the database itself, and the migrations from each version to the next.

A version is the name of the last migration that was applied. Alembic does the same for many tables and branching
histories; here there are two groups of tables, one of which (the queue's) comes with its own migrations as plain SQL.
"""

from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import dataclass

from sqlalchemy import Column, Connection, Engine, MetaData, String, Table, inspect, select, text

_versions = Table(
    "ipfit_versions", MetaData(), Column("part", String, primary_key=True), Column("version", String, nullable=False)
)
# The number of the lock under which a process prepares the database: any number, but the same in every process.
_PREPARING = 4_711_001


class DatabaseVersionError(Exception):
    """The tables are of a version that this program does not know."""


@dataclass(frozen=True)
class MigrationStep:
    """A group of tables with one version.

    Attributes
    ----------
    name
        The name under which their version is stored.
    table
        The name of one of them.
    make
        Creates them, as they are after the last migration.
    steps
        The SQL of each migration by its name, the oldest first. The first has no SQL: its name is the first version.
    columns
        The columns that `table` must have in the end.

    """

    name: str
    table: str
    make: Callable[[Connection], object]
    steps: dict[str, str]
    columns: frozenset[str] = frozenset()


def prepare(engine: Engine, parts: Iterable[MigrationStep]) -> None:
    """Create the tables that do not exist, and migrate older ones, in one transaction.

    Raises
    ------
    DatabaseVersionError
        If the tables are of a later version, or of one that is not stored and lack columns.

    """
    with engine.begin() as connection:
        if engine.dialect.name == "sqlite":
            connection.exec_driver_sql(
                "BEGIN IMMEDIATE"
            )  # the driver itself begins a transaction with the first INSERT only
        else:
            connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": _PREPARING})
        _versions.create(connection, checkfirst=True)
        for part in parts:
            _migrate(connection, part)


def _migrate(connection: Connection, part: MigrationStep) -> None:
    """Create or migrate one group of tables."""
    query = select(_versions.c.version).where(_versions.c.part == part.name)
    stored, newest = connection.execute(query).scalar(), list(part.steps)[-1]
    if stored is None:  # created before versions were stored, or not created yet
        if not inspect(connection).has_table(part.table):
            part.make(connection)
        connection.execute(_versions.insert().values(part=part.name, version=newest))
    elif stored != newest:
        for step in _steps_after(stored, part):
            with closing(connection.connection.cursor()) as cursor:  # the driver's own, for which % has no meaning
                cursor.execute(part.steps[step])
        connection.execute(_versions.update().where(_versions.c.part == part.name).values(version=newest))
    existing = {column["name"] for column in inspect(connection).get_columns(part.table)}
    if missing := sorted(part.columns - existing):
        raise DatabaseVersionError(f"the table {part.table} has no {', '.join(missing)}: an unreleased ipfit made it")


def _steps_after(version: str, part: MigrationStep) -> list[str]:
    """Return the names of the migrations that come after a version."""
    names = list(part.steps)
    if version not in names:
        raise DatabaseVersionError(
            f"the tables of {part.name} are of version {version}, which this ipfit does not know; its last is "
            f"{names[-1]}. A newer ipfit made or changed them: use that one"
        )
    return names[names.index(version) + 1 :]
