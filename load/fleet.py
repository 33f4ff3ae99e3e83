"""The processes under test: started, killed at random, and started again as by a supervisor."""

import os
import random
import signal
import socket
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread, Timer

import psycopg

from load.program import Program
from tests.service.postgres import Postgres
from tests.service.running import alive

# Seconds after which a dead process is started again.
RESTART = 0.2
# Seconds for which a worker is stopped: longer than its leases and than others need to take over its fits.
FREEZE = 12.0

Fault = Callable[[random.Random], None]


class Fleet:
    """An embedded server, or a PostgreSQL with two replicas of the API and two workers."""

    def __init__(self, folder: Path, *, cluster: bool) -> None:
        self.folder = folder
        self.postgres = Postgres() if cluster else None
        self.database = self.postgres.database() if self.postgres else None
        self.ports = [_free_port() for _ in range(2 if cluster else 1)]
        self.blobs = folder / "blobs" if cluster else folder / "data" / "blobs"
        shared: dict[str, object] = {}
        if cluster:
            shared = {"DATABASE_URL": self.database, "BLOBS_URL": f"file://{self.blobs}"}
        self.servers = [
            Program("serve", folder / f"serve-{port}.log", {"PORT": port, "DATA_DIR": folder / "data", **shared})
            for port in self.ports
        ]
        self.worker_programs = (
            [Program("worker", folder / f"worker-{i}.log", shared) for i in range(2)] if cluster else []
        )
        self.kills: Counter[str] = Counter()
        self.other: Counter[str] = Counter()
        self._caused: set[Fault] = set()
        self._ended = Event()
        self._keeper = Thread(target=self._keep_running, name="supervisor", daemon=True)

    def start(self) -> None:
        """Start all programs, and start each again when it has ended."""
        self._keeper.start()

    def end(self) -> None:
        """End all programs."""
        self._ended.set()
        self._keeper.join()
        for program in [*self.servers, *self.worker_programs]:
            if program.process is not None:
                program.process.kill()
                program.process.wait()
        if self.postgres is not None:
            self.postgres.remove()

    def cause_fault(self, generator: random.Random) -> None:
        """Cause one random fault: first each kind of fault once, then any by its weight."""
        faults: dict[Fault, int] = {
            self._kill_worker_process: 50,
            self._kill_fork_server: 8,
            self._kill_tracker: 4,
            self._kill_server: 18,
            self._stop_gently: 4,
        }
        if self.postgres is not None:
            faults |= {self._kill_worker_program: 16, self._kill_database: 3, self._cut: 8}
            faults |= {self._kill_backend: 4, self._kill_helper: 2, self._freeze: 3}
        missing = [one for one in faults if one not in self._caused]
        chosen = generator.choice(missing) if missing else generator.choices(list(faults), list(faults.values()))[0]
        before = self.kills.total() + self.other.total()
        chosen(generator)
        if self.kills.total() + self.other.total() > before:
            self._caused.add(chosen)

    def _kill_worker_process(self, generator: random.Random) -> None:
        self._kill(
            "worker process", [pid for one in self.servers + self.worker_programs for pid in one.workers()], generator
        )

    def _kill_fork_server(self, generator: random.Random) -> None:
        self._kill(
            "fork server", [pid for one in self.servers + self.worker_programs for pid in one.fork_servers()], generator
        )

    def _kill_tracker(self, generator: random.Random) -> None:
        self._kill(
            "resource tracker",
            [pid for one in self.servers + self.worker_programs for pid in one.trackers()],
            generator,
        )

    def _kill_server(self, generator: random.Random) -> None:
        self._kill("ipfit serve", [one.pid for one in self.servers if one.pid], generator)

    def _kill_worker_program(self, generator: random.Random) -> None:
        self._kill("ipfit worker", [one.pid for one in self.worker_programs if one.pid], generator)

    def _kill_database(self, _random: random.Random) -> None:
        assert self.postgres is not None  # noqa: S101 - only a cluster has this fault
        self.postgres.kill()
        self.kills["PostgreSQL"] += 1
        time.sleep(0.5)
        self.postgres.start()

    def _kill_backend(self, _random: random.Random) -> None:
        assert self.postgres is not None  # noqa: S101 - as above
        with suppress(psycopg.Error):  # it may be recovering from the last time
            self.kills["PostgreSQL backend"] += self.postgres.kill_one()

    def _kill_helper(self, _random: random.Random) -> None:
        """Kill a PostgreSQL process that serves no client, such as the one that writes checkpoints."""
        assert self.postgres is not None  # noqa: S101 - as above
        with suppress(psycopg.Error):
            self.kills["PostgreSQL helper"] += self.postgres.kill_one(client=False)

    def _cut(self, _random: random.Random) -> None:
        assert self.postgres is not None  # noqa: S101 - as above
        with suppress(psycopg.Error):
            self.other["connections cut"] += self.postgres.cut(0.5)

    def _freeze(self, generator: random.Random) -> None:
        """Stop a worker for longer than its leases last; then it continues with fits that others have taken over."""
        if pids := [one.pid for one in self.worker_programs if one.pid]:
            pid = generator.choice(pids)
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGSTOP)
                self.other["SIGSTOP"] += 1
                Timer(FREEZE, _resume, [pid]).start()

    def _stop_gently(self, generator: random.Random) -> None:
        """Send SIGTERM to a program, once or twice."""
        program = generator.choice(self.servers + self.worker_programs)
        if program.process is not None and program.pid is not None:
            for _ in range(generator.choice((1, 2))):
                program.process.send_signal(signal.SIGTERM)
                self.other["SIGTERM"] += 1
                time.sleep(0.1)

    def _kill(self, kind: str, pids: list[int], generator: random.Random) -> None:
        if pids:
            with suppress(ProcessLookupError):
                pid = generator.choice(pids)
                os.kill(pid, signal.SIGKILL)
                self.kills[kind] += 1
                while alive(pid) and kind in {"ipfit serve", "ipfit worker"}:
                    time.sleep(0.01)

    def _keep_running(self) -> None:
        while not self._ended.wait(RESTART):
            for program in [*self.servers, *self.worker_programs]:
                program.run()


def _resume(pid: int) -> None:
    with suppress(ProcessLookupError):  # it was killed meanwhile
        os.kill(pid, signal.SIGCONT)


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
    return port
