"""Clients, and servers that one test may do with as it likes."""

from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest

from tests.service.postgres import Postgres
from tests.service.running import Server

Start = Callable[..., Server]


@pytest.fixture(scope="session")
def client(shared: Server) -> httpx.Client:
    """Return a client of the shared server."""
    return shared.client


@pytest.fixture(scope="session")
def postgres() -> Iterator[Postgres]:
    """Start a PostgreSQL for tests that leave it running."""
    server = Postgres()
    yield server
    server.remove()


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start servers on one data folder, one after the other; what still runs in the end is killed."""
    started: list[Server] = []

    def one(**settings: object) -> Server:
        started.append(Server(tmp_path / "data", **settings))
        return started[-1]

    yield one
    for server in started:
        if server.process.poll() is None:
            server.kill()
