"""A cluster for tests: replicas of the API and workers around a PostgreSQL, each in a process of its own."""

from pathlib import Path

import psycopg

from tests.service.postgres import Postgres
from tests.service.running import Server, Worker, until


class Cluster:
    """A database of its own, and the processes around it."""

    def __init__(self, folder: Path, postgres: Postgres, **settings: object) -> None:
        self._settings: dict[str, object] = {
            "DATABASE_URL": settings.get("DATABASE_URL") or postgres.database(),
            "BLOBS_URL": f"file://{folder / 'blobs'}",
            "WORKERS": 1,
            "LEASE": 3,
            **settings,
        }
        self._folder, self.database = folder, str(self._settings["DATABASE_URL"])
        self.servers: list[Server] = []
        self.workers: list[Worker] = []

    def serve(self, **settings: object) -> Server:
        self.servers.append(Server(self._place(), **self._settings | settings))
        return self.servers[-1]

    def work(self, **settings: object) -> Worker:
        self.workers.append(Worker(self._place(), **self._settings | settings))
        return self.workers[-1]

    def holders(self) -> set[str]:
        """Return the names of the lease holders of running fits."""
        with psycopg.connect(str(self._settings["DATABASE_URL"])) as connection:
            return {row[0] for row in connection.execute("SELECT holder FROM fits WHERE holder IS NOT NULL")}

    def await_workers(self) -> None:
        """Return when each worker started so far waits for fits: its processes have started, and it asks for jobs.

        Each has two rows in Procrastinate's list, one for fits and one for the upkeep.
        """

        def listed() -> int:
            with psycopg.connect(self.database) as connection:
                row = connection.execute("SELECT count(*) FROM procrastinate_workers").fetchone()
            return int(row[0]) if row else 0

        until(lambda: listed() >= 2 * len(self.workers), 60.0)

    def count(self) -> int:
        """Return how many fits are stored."""
        with psycopg.connect(str(self._settings["DATABASE_URL"])) as connection:
            row = connection.execute("SELECT count(*) FROM fits").fetchone()
        return int(row[0]) if row else 0

    def end(self) -> None:
        for program in [*self.servers, *self.workers]:
            if program.process.poll() is None:
                program.kill()
            elif isinstance(program, Server):
                program.client.close()

    def _place(self) -> Path:
        place = self._folder / f"{len(self.servers)}-{len(self.workers)}"
        place.mkdir()
        return place / "data"
