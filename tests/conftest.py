"""The server that most tests share."""

from collections.abc import Iterator

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

from tests.service.running import Server

# Tests that start servers, kill processes and measure time, by the beginning of their ids. Two of them at once on two
# cores would disturb each other, so one process runs all of them, while others run the tests of the mathematics.
ONE_AFTER_THE_OTHER = ("tests/service/", "tests/test_readme.py", "tests/test_docs.py")
# Of these, files that only read and compute, or that talk to one server and measure no time: they may run beside.
BESIDE = tuple(
    f"tests/service/{name}"
    for name in (
        "points/", "test_callback_addresses", "test_callback_sender", "test_cli_fit", "test_fair_queue",
        "test_fair_seats", "test_files", "test_fuzz_points", "test_hostile_requests", "test_meshes", "test_npy",
        "test_openapi", "test_options", "test_outlines", "test_picture", "test_point_sets", "test_preferences",
        "test_split_tasks", "test_versions",
    )
)  # fmt: skip


class Scheduling(LoadScopeScheduling):
    """Give each process whole files of tests, and the tests above to one process, which starts with them.

    pytest-xdist has marks for such groups, but its 3.8 does not find them with pytest 9.2.
    """

    def _split_scope(self, nodeid: str) -> str:
        alone = nodeid.startswith(ONE_AFTER_THE_OTHER) and not nodeid.startswith(BESIDE)
        return "one after the other" if alone else nodeid.partition("::")[0]


def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> Scheduling:
    """Return how tests are shared out between processes, if there are several (`-n`)."""
    return Scheduling(config, log)


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Start a server with the default settings, for tests that leave it as they found it."""
    server = Server(tmp_path_factory.mktemp("shared") / "data")
    yield server
    server.stop()


@pytest.fixture(scope="session")
def server(shared: Server) -> str:
    """Return the address of that server."""
    return shared.url
