"""Fixtures: a client of a shared server, stores on both engines, and servers that a test may stop and kill."""

from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
from sqlalchemy import Engine, text

from service.api_keys import new_key
from service.jobs.admission import Admission
from service.queue.procrastinate_jobs import ProcrastinateJobs
from service.store.engines import postgres_engine, sqlite_engine
from service.store.fits import SqlFits
from tests.service.postgres import Postgres
from tests.service.running import Server
from tests.service.stores import LIMIT, QUEUE

Start = Callable[..., Server]


@pytest.fixture(scope="session")
def client(shared: Server) -> httpx.Client:
    """Return a client of the shared server."""
    return shared.client


@pytest.fixture(scope="session")
def postgres() -> Iterator[Postgres]:
    """Start a PostgreSQL that all tests share and none stops."""
    server = Postgres()
    yield server
    server.remove()


@pytest.fixture(scope="session")
def database(postgres: Postgres) -> Iterator[Engine]:
    """Return an engine on a PostgreSQL with all tables."""
    engine = postgres_engine(postgres.database(), QUEUE)
    yield engine
    engine.dispose()


@pytest.fixture
def cluster_store(database: Engine) -> SqlFits:
    """Return an empty store with a queue in the same database."""
    with database.begin() as connection:
        connection.execute(text("TRUNCATE fits, turns, callbacks, acceptances, procrastinate_jobs CASCADE"))
    return SqlFits(database, Admission(LIMIT), ProcrastinateJobs())


@pytest.fixture(params=["sqlite", "postgresql"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[SqlFits]:
    """Return an empty store, on each engine."""
    if request.param == "postgresql":
        yield request.getfixturevalue("cluster_store")
        return
    engine = sqlite_engine(tmp_path / "fits.sqlite")
    yield SqlFits(engine, Admission(LIMIT))
    engine.dispose()


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Return a function that starts a server on one data folder; servers that still run in the end are killed."""
    started: list[Server] = []

    def one(**settings: object) -> Server:
        started.append(Server(tmp_path / "data", **settings))
        return started[-1]

    yield one
    for server in started:
        if server.process.poll() is None:
            server.kill()


@pytest.fixture
def keys(tmp_path: Path) -> tuple[Path, str, str]:
    """Return a file with two callers, the second with quotas, and their keys."""
    file = tmp_path / "keys.toml"
    (first, entry), (second, other) = new_key("ada"), new_key("bob.2")
    file.write_text(f"{entry}\n{other}waiting = 2\nhourly = 3\n", encoding="utf-8")
    return file, first, second
