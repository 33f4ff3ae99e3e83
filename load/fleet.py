"""The processes under test: started, killed at random, and started again as a supervisor would."""

import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread

import psycopg

from tests.service.postgres import Postgres
from tests.service.running import alive, children

COMMAND = Path(sys.executable).parent / "ipfit"
# Short leases, so that what a dead process held comes back within seconds; a queue that fills.
SETTINGS: dict[str, object] = {
    "WORKERS": 1,
    "SHORT_WORKERS": 1,
    "LEASE": 5,
    "QUEUE_LIMIT": 12,
    "SHUTDOWN_GRACE": 1,
    "TASKS_PER_WORKER": 20,
}
# Seconds after which a dead process is started again.
RESTART = 0.2

Strike = Callable[[random.Random], None]


class Program:
    """One `ipfit` command, run again whenever it has ended."""

    def __init__(self, command: str, log: Path, settings: dict[str, object]) -> None:
        self._command, self._log = command, log
        self._settings = {f"IPFIT_{name}": str(value) for name, value in (SETTINGS | settings).items()}
        self._settings["TMPDIR"] = str(log.parent)  # what the killed leave behind goes when the run is over
        self.process: subprocess.Popen[bytes] | None = None
        self.starts = 0

    def run(self) -> None:
        """Start, unless it runs."""
        if self.process is None or self.process.poll() is not None:
            self.starts += 1
            with self._log.open("ab") as log:
                self.process = subprocess.Popen(  # noqa: S603 - our own command
                    [COMMAND, self._command], env=os.environ | self._settings, stdout=log, stderr=log
                )

    @property
    def pid(self) -> int | None:
        """Return its process, if it runs."""
        return self.process.pid if self.process is not None and self.process.poll() is None else None

    def fork_servers(self) -> list[int]:
        """Return the processes that its workers come from."""
        return [] if self.pid is None else [one for one in children(self.pid) if children(one)]

    def workers(self) -> list[int]:
        """Return the processes that fit."""
        return [] if self.pid is None else [worker for one in children(self.pid) for worker in children(one)]


class Fleet:
    """An embedded server, or a PostgreSQL with two replicas of the API and two workers."""

    def __init__(self, folder: Path, *, cluster: bool) -> None:
        self.folder = folder
        self.postgres = Postgres() if cluster else None
        self.database = self.postgres.database() if self.postgres else None
        self.ports = [_free_port() for _ in range(2 if cluster else 1)]
        shared: dict[str, object] = {}
        if cluster:
            shared = {"DATABASE_URL": self.database, "BLOBS_URL": f"file://{folder}/blobs"}
        self.servers = [
            Program("serve", folder / f"serve-{port}.log", {"PORT": port, "DATA_DIR": folder / "data", **shared})
            for port in self.ports
        ]
        self.hands = [Program("worker", folder / f"worker-{i}.log", shared) for i in range(2)] if cluster else []
        self.kills: Counter[str] = Counter()
        self.other: Counter[str] = Counter()
        self._ended = Event()
        self._keeper = Thread(target=self._keep_running, name="supervisor", daemon=True)

    def start(self) -> None:
        """Start everything, and keep it running."""
        self._keeper.start()

    def end(self) -> None:
        """End everything."""
        self._ended.set()
        self._keeper.join()
        for program in [*self.servers, *self.hands]:
            if program.process is not None:
                program.process.kill()
                program.process.wait()
        if self.postgres is not None:
            self.postgres.remove()

    def strike(self, chance: random.Random) -> None:
        """Do one random thing that a machine room does to processes."""
        strikes: dict[Strike, int] = {
            self._kill_worker: 50,
            self._kill_fork_server: 8,
            self._kill_server: 18,
            self._stop_gently: 4,
        }
        if self.postgres is not None:
            strikes |= {self._kill_hand: 16, self._kill_database: 3, self._kill_backend: 5, self._cut: 8}
        chance.choices(list(strikes), list(strikes.values()))[0](chance)

    def _kill_worker(self, chance: random.Random) -> None:
        self._kill("worker process", [pid for one in self.servers + self.hands for pid in one.workers()], chance)

    def _kill_fork_server(self, chance: random.Random) -> None:
        self._kill("fork server", [pid for one in self.servers + self.hands for pid in one.fork_servers()], chance)

    def _kill_server(self, chance: random.Random) -> None:
        self._kill("ipfit serve", [one.pid for one in self.servers if one.pid], chance)

    def _kill_hand(self, chance: random.Random) -> None:
        self._kill("ipfit worker", [one.pid for one in self.hands if one.pid], chance)

    def _kill_database(self, _chance: random.Random) -> None:
        assert self.postgres is not None  # noqa: S101 - only then is this among the strikes
        self.postgres.kill()
        self.kills["PostgreSQL"] += 1
        time.sleep(0.5)
        self.postgres.start()

    def _kill_backend(self, _chance: random.Random) -> None:
        assert self.postgres is not None  # noqa: S101 - as above
        with suppress(psycopg.Error):  # it may be recovering from the last time
            self.kills["PostgreSQL backend"] += self.postgres.kill_one()

    def _cut(self, _chance: random.Random) -> None:
        assert self.postgres is not None  # noqa: S101 - as above
        with suppress(psycopg.Error):
            self.other["connections cut"] += self.postgres.cut(0.5)

    def _stop_gently(self, chance: random.Random) -> None:
        """Stop a program as its supervisor does, once or with impatience."""
        program = chance.choice(self.servers + self.hands)
        if program.process is not None and program.pid is not None:
            for _ in range(chance.choice((1, 2))):
                program.process.send_signal(signal.SIGTERM)
                self.other["SIGTERM"] += 1
                time.sleep(0.1)

    def _kill(self, kind: str, pids: list[int], chance: random.Random) -> None:
        if pids:
            with suppress(ProcessLookupError):
                pid = chance.choice(pids)
                os.kill(pid, signal.SIGKILL)
                self.kills[kind] += 1
                while alive(pid) and kind in {"ipfit serve", "ipfit worker"}:
                    time.sleep(0.01)

    def _keep_running(self) -> None:
        while not self._ended.wait(RESTART):
            for program in [*self.servers, *self.hands]:
                program.run()


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
    return port
