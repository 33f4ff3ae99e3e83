"""A server under load: embedded in one process, or a cluster of an API, a worker and a PostgreSQL."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.running import Server

ENGINES = ("embedded", "cluster")
# Two processes for fits on both engines; all clients have one address.
SETTINGS: dict[str, object] = {"WORKERS": 2, "SHORT_WORKERS": 0, "CLIENT_SHARE": 1}
LEASE = 60  # seconds; a cluster of tests has a shorter one


@dataclass(frozen=True)
class Engine:
    """A running engine.

    Attributes
    ----------
    port
        Where it answers HTTP.
    programs
        Its processes, by what they are; each has started others.

    """

    port: int
    programs: dict[str, int]

    @property
    def supervisors(self) -> list[int]:
        """Return the processes that accept fits and hand them to workers."""
        return [pid for name, pid in self.programs.items() if name != "PostgreSQL"]


@contextmanager
def running(engine: str, folder: Path, **settings: object) -> Iterator[Engine]:
    """Yield a running engine, with everything that it stores in `folder`."""
    start = _embedded if engine == "embedded" else _cluster
    with start(folder, SETTINGS | settings) as started:
        yield started


@contextmanager
def _embedded(folder: Path, settings: dict[str, object]) -> Iterator[Engine]:
    server = Server(folder / "data", **settings)
    try:
        yield Engine(_port(server), {"server": server.process.pid})
    finally:
        server.kill()


@contextmanager
def _cluster(folder: Path, settings: dict[str, object]) -> Iterator[Engine]:
    postgres = Postgres()
    cluster = Cluster(folder, postgres, **settings | {"LEASE": LEASE})
    try:
        worker, api = cluster.work(), cluster.serve()
        cluster.await_workers()
        programs = {"server": api.process.pid, "worker": worker.process.pid, "PostgreSQL": postgres.process.pid}
        yield Engine(_port(api), programs)
    finally:
        cluster.end()
        postgres.remove()


def _port(server: Server) -> int:
    return int(server.url.rpartition(":")[2])
