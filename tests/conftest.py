"""The server that most tests share."""

from collections.abc import Iterator

import pytest

from tests.service.running import Server


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Start a server with the default settings, for tests that leave it as they found it."""
    server = Server(tmp_path_factory.mktemp("shared") / "data", measured=True)
    yield server
    server.stop()


@pytest.fixture(scope="session")
def server(shared: Server) -> str:
    """Return the address of that server."""
    return shared.url
