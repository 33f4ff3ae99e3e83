"""Databases of every version: created, migrated or refused, and never left half migrated."""

import dataclasses
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from sqlalchemy import Column, Connection, Engine, MetaData, Table, create_engine, inspect, text

from service.jobs.fit import FitStatus
from service.queue.procrastinate_jobs import make, steps
from service.store.migrations import DatabaseVersionError, MigrationStep, prepare
from service.store.schema import FITS
from service.store.schema import fits as table
from tests.service.bodies import ellipse, npy
from tests.service.postgres import Postgres
from tests.service.running import Program, Server, until

NEWER = dataclasses.replace(
    FITS, steps=FITS.steps | {"0.2.9": "ALTER TABLE fits ADD COLUMN note VARCHAR DEFAULT '100 %'", "0.3.0": "SELECT 1"}
)
QUEUE = MigrationStep("procrastinate", "procrastinate_jobs", make, steps())
Make = Callable[[], Engine]


@pytest.fixture(params=["sqlite", "postgresql"])
def engine(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Engine]:
    if request.param == "postgresql":
        url = request.getfixturevalue("postgres").database().replace("postgresql:", "postgresql+psycopg:")
    else:
        url = f"sqlite:///{tmp_path / 'fits.sqlite'}"
    made = create_engine(url)
    yield made
    made.dispose()


NEWEST = list(FITS.steps)[-1]


def columns(engine: Engine) -> set[str]:
    return {column["name"] for column in inspect(engine).get_columns("fits")}


def version(engine: Engine) -> object:
    with engine.connect() as connection:
        return connection.execute(text("SELECT version FROM ipfit_versions WHERE part = 'fits'")).scalar()


def test_a_new_database_is_made_once_though_many_begin_together(engine: Engine) -> None:
    with ThreadPoolExecutor(6) as threads:
        list(threads.map(lambda _: prepare(engine, [FITS]), range(12)))
    assert columns(engine) == FITS.columns
    assert version(engine) == NEWEST


def test_an_older_database_is_brought_up_to_date_and_keeps_what_is_in_it(engine: Engine) -> None:
    prepare(engine, [FITS])
    with engine.begin() as connection:
        connection.execute(
            text(
                "INSERT INTO fits (id, status, input, dimension, points, options, client, cost, payload, created,"
                " touched, attempt, crashes, abandoned, size, parts, unsummed) VALUES ('one', 'accepted', '', 2, 9,"
                " '', '', 1, '', '2026-01-01', '2026-01-01', 0, 0, 0, 0, 0, 0)"
            )
        )
    for _ in range(2):
        prepare(engine, [NEWER])
        assert version(engine) == "0.3.0"
    with engine.connect() as connection:
        assert connection.execute(text("SELECT id, note FROM fits")).all() == [("one", "100 %")]
    with pytest.raises(DatabaseVersionError, match=r"of version 0\.3\.0, which this ipfit does not know"):
        prepare(engine, [FITS])


def test_the_tables_of_the_first_release_become_those_of_this_one(engine: Engine) -> None:
    new = {"parts", "unsummed", "whole", "slice", "summary", "owner", "turn", "place", "short_lane"}
    old = Table("fits", MetaData(), *(Column(c.name, c.type) for c in table.columns if c.name not in new))
    prepare(engine, [dataclasses.replace(FITS, make=old.create, steps={"0.1.0": ""}, columns=frozenset())])
    with engine.begin() as connection:
        connection.execute(old.insert().values(id="one", status=FitStatus.ACCEPTED))
    prepare(engine, [FITS])
    assert columns(engine) == FITS.columns
    assert "ix_fits_whole" in {index["name"] for index in inspect(engine).get_indexes("fits")}
    with engine.connect() as connection:
        assert connection.execute(
            text("SELECT parts, unsummed, whole, slice, summary, owner, turn, place FROM fits")
        ).all() == [(0, 0, None, None, None, "", 0.0, 0)]


def shape(engine: Engine, name: str) -> list[tuple[str, str, bool, bool]]:
    """Return the columns of a table by name: name, type, whether they may be null and whether they have an index."""
    found = inspect(engine)
    indexed = {column for index in found.get_indexes(name) for column in index["column_names"]}
    kinds = {one["name"]: one["type"].compile(engine.dialect) for one in found.get_columns(name)}
    times = {"DATETIME": "NUMERIC"}  # the same for SQLite, which knows neither of the two names of a time
    return sorted(
        (one["name"], times.get(kinds[one["name"]], kinds[one["name"]]), one["nullable"], one["name"] in indexed)
        for one in found.get_columns(name)
    )


@pytest.mark.parametrize("name", ["callbacks", "acceptances", "turns"])
def test_a_table_that_a_migration_makes_is_like_a_new_one(engine: Engine, name: str) -> None:
    prepare(engine, [FITS])
    made = shape(engine, name)
    with engine.begin() as connection:
        connection.execute(text(f"DROP TABLE {name}"))
        for step in (step for step in FITS.steps if step.startswith(f"0.2.0 {name}")):
            connection.execute(text(FITS.steps[step]))
    assert shape(engine, name) == made


def test_a_step_that_fails_leaves_the_database_as_it_was(engine: Engine) -> None:
    prepare(engine, [FITS])
    broken = dataclasses.replace(NEWER, steps=NEWER.steps | {"0.3.0": "ALTER TABLE elsewhere ADD COLUMN note VARCHAR"})
    with pytest.raises(Exception, match="elsewhere"):
        prepare(engine, [broken])
    assert columns(engine) == FITS.columns
    assert version(engine) == NEWEST


def test_a_database_from_before_versions_is_taken_if_it_has_all_that_it_needs(engine: Engine) -> None:
    prepare(engine, [FITS])
    with engine.begin() as connection:
        connection.execute(text("DROP TABLE ipfit_versions"))
    prepare(engine, [FITS])
    assert version(engine) == NEWEST
    with engine.begin() as connection:
        connection.execute(text("DROP TABLE ipfit_versions"))
        connection.execute(text("ALTER TABLE fits DROP COLUMN abandoned"))
    with pytest.raises(DatabaseVersionError, match="has no abandoned"):
        prepare(engine, [FITS])


def catalogue(engine: Engine) -> list[object]:
    """Return every column, function and index of the queue."""
    query = text(
        "SELECT table_name || '.' || column_name || ' ' || data_type FROM information_schema.columns"
        " WHERE table_name LIKE 'procrastinate%' UNION SELECT proname || pg_get_function_arguments(oid) FROM pg_proc"
        " WHERE proname LIKE 'procrastinate%' UNION SELECT indexname FROM pg_indexes"
        " WHERE tablename LIKE 'procrastinate%' ORDER BY 1"
    )
    with engine.connect() as connection:
        return list(connection.execute(query).scalars())


def test_the_tables_of_an_older_procrastinate_become_those_of_this_one(postgres: Postgres) -> None:
    names = list(QUEUE.steps)
    at = next(i for i, name in enumerate(names) if name.startswith("03."))

    def make_old(connection: Connection) -> None:
        for name in names[:at]:
            connection.exec_driver_sql(QUEUE.steps[name].replace("%", "%%"))

    old, new = (create_engine(postgres.database().replace("postgresql:", "postgresql+psycopg:")) for _ in range(2))
    prepare(new, [QUEUE])
    prepare(old, [dataclasses.replace(QUEUE, make=make_old, steps=dict(list(QUEUE.steps.items())[:at]))])
    assert catalogue(old) != catalogue(new)
    prepare(old, [QUEUE])
    assert catalogue(old) == catalogue(new)
    for engine in (old, new):
        engine.dispose()


def test_a_server_refuses_the_database_of_a_newer_one_and_says_so(tmp_path: Path, postgres: Postgres) -> None:
    folder, shared = tmp_path / "data", postgres.database()
    folder.mkdir()
    for url in (f"sqlite:///{folder / 'fits.sqlite'}", shared.replace("postgresql:", "postgresql+psycopg:")):
        engine = create_engine(url)
        prepare(engine, [NEWER])
        engine.dispose()
    for command, settings in (("serve", {}), ("serve", {"DATABASE_URL": shared}), ("worker", {"DATABASE_URL": shared})):
        program = Program(command, folder, **settings)
        assert program.process.wait(60.0) != 0
        assert "of version 0.3.0, which this ipfit does not know" in program.log


def test_a_replica_that_starts_before_its_database_answers_503_until_it_is_there(tmp_path: Path) -> None:
    postgres = Postgres()
    try:
        url = postgres.database()
        postgres.kill()
        server = Server(tmp_path / "data", ready=False, DATABASE_URL=url, BLOBS_URL=f"file://{tmp_path / 'blobs'}")
        assert server.client.get("/livez").is_success
        for answer in (
            server.client.get("/readyz"),
            server.client.post("/v1/fits", content=npy(ellipse()), headers={"Content-Type": "application/x-npy"}),
        ):
            assert (answer.status_code, answer.json()["type"]) == (503, "/problems/not-ready")
        other = Server(tmp_path / "other", ready=False, DATABASE_URL=url, BLOBS_URL=f"file://{tmp_path / 'blobs'}")
        other.stop()  # which does not wait for a database either
        postgres.start()
        until(lambda: server.client.get("/readyz").is_success)
        assert server.fit(npy(ellipse()), prefer="respond-async")["status"] == "accepted"
        server.kill()
    finally:
        postgres.remove()
