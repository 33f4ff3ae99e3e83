"""Real servers: `ipfit serve` in a process and a data folder of its own, and information about its processes."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import httpx

T = TypeVar("T")
LISTENING = re.compile(r"Uvicorn running on (http://\S+)")
COMMAND = Path(sys.executable).parent / "ipfit"


def until(found: Callable[[], T], seconds: float = 30.0) -> T:
    """Return the result of `found` as soon as it is true."""
    end = time.monotonic() + seconds
    while not (value := found()):
        assert time.monotonic() < end, f"waited {seconds} s in vain"
        time.sleep(0.02)
    return value


class Program:
    """One run of an `ipfit` command. Settings are given by the name of the variable without IPFIT_.

    Coverage is measured in the server that most tests share, and not in others: they would take twice as long.
    """

    def __init__(self, command: str, folder: Path, **settings: object) -> None:
        self.folder = folder
        self._log = folder.parent / f"{folder.name}-{time.monotonic_ns()}.log"
        dropped = ("IPFIT_",) if settings.pop("measured", False) else ("IPFIT_", "COVERAGE_")
        kept = {name: value for name, value in os.environ.items() if not name.startswith(dropped)}
        told = {"PORT": 0, "DATA_DIR": folder, "WORKERS": 2, "SHORT_WORKERS": 0, "SHUTDOWN_GRACE": 0, **settings}
        with self._log.open("wb") as log:
            self.process = subprocess.Popen(  # noqa: S603 - our own command
                [COMMAND, command],
                env=kept | {f"IPFIT_{name}": str(value) for name, value in told.items()},
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    @property
    def log(self) -> str:
        return self._log.read_text(encoding="utf-8")

    def kill(self) -> None:
        """Kill it with all its processes, as a power cut does."""
        self.process.kill()
        self.process.wait(10.0)

    def workers(self) -> list[int]:
        """Return the worker processes: the children of the fork server."""
        return [worker for child in children(self.process.pid) for worker in children(child)]

    def busy(self, seconds: float = 0.3) -> list[int]:
        """Return the workers that used the processor for most of so many seconds of it."""
        before = {pid: ticks(pid) for pid in self.workers()}
        time.sleep(seconds)
        clock = os.sysconf("SC_CLK_TCK")
        return [pid for pid, at in before.items() if ticks(pid) - at > 0.2 * seconds * clock]


class Worker(Program):
    """One run of `ipfit worker`."""

    def __init__(self, folder: Path, **settings: object) -> None:
        super().__init__("worker", folder, **settings)

    def stop(self, seconds: float = 15.0) -> None:
        """Send SIGTERM; the worker must exit with 0 and leave no process behind."""
        left = self.workers()
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(seconds) == 0, self.log
        assert not [pid for pid in left if alive(pid)]


class Server(Program):
    """One run of `ipfit serve`."""

    def __init__(self, folder: Path, **settings: object) -> None:
        ready = settings.pop("ready", True)  # whether it will be
        super().__init__("serve", folder, **settings)
        self.url = until(self._listening, 60.0)
        self.client = httpx.Client(base_url=self.url, timeout=60.0)
        if ready:
            until(lambda: self.client.get("/readyz").is_success)

    def _listening(self) -> str:
        assert self.process.poll() is None, self.log
        found = LISTENING.search(self.log)
        return found.group(1) if found else ""

    def stop(self) -> None:
        """Send SIGTERM; the server must exit with 0 at once and leave no process behind."""
        left = self.workers()
        self.client.close()
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(10.0) == 0, self.log
        assert not [pid for pid in left if alive(pid)]
        assert "Traceback" not in self.log, self.log

    def kill(self) -> None:
        """Kill the server with all its processes, as a power cut does."""
        self.client.close()
        super().kill()

    def fit(self, content: bytes, query: str = "", prefer: str = "wait=60") -> dict[str, Any]:
        """Send an npy and return the fit."""
        headers = {"Content-Type": "application/x-npy", "Prefer": prefer}
        answer = self.client.post(f"/v1/fits?{query}", content=content, headers=headers)
        assert answer.status_code in (200, 202), answer.text
        fit: dict[str, Any] = answer.json()
        return fit

    def look(self, fit: dict[str, Any], wait: int = 0) -> dict[str, Any]:
        """Return the fit as it is now, or after so many seconds."""
        answer = self.client.get(f"/v1/fits/{fit['id']}", headers={"Prefer": f"wait={wait}"})
        assert answer.status_code == 200, answer.text
        now: dict[str, Any] = answer.json()
        return now

    def under_way(self, fit: dict[str, Any], degree: int = 2) -> dict[str, Any]:
        """Return the fit when it has tried this many degrees, and is still running."""

        def far_enough() -> dict[str, Any]:
            now = self.look(fit)
            assert now["status"] in ("accepted", "running"), now
            return now if len(now["progress"]) >= degree else {}

        return until(far_enough)


def children(pid: int) -> list[int]:
    return [other for other, parent in _parents().items() if parent == pid]


def parent(pid: int) -> int:
    return _parents()[pid]


def alive(pid: int) -> bool:
    return _stat(pid)[:1] not in ([], ["Z"])


def ticks(pid: int) -> int:
    """Return the processor time used, in clock ticks."""
    stat = _stat(pid)
    return int(stat[11]) + int(stat[12]) if stat else 0


def _parents() -> dict[int, int]:
    found = {int(folder.name): _stat(int(folder.name)) for folder in Path("/proc").iterdir() if folder.name.isdigit()}
    return {pid: int(stat[1]) for pid, stat in found.items() if stat and stat[0] != "Z"}


def _stat(pid: int) -> list[str]:
    """Return the fields of /proc/PID/stat that follow the command's name; none if the process is gone."""
    try:
        return (Path("/proc") / str(pid) / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return []
