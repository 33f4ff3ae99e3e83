"""One container that runs, as much of it as a test needs."""

import signal
import socket
import subprocess
from pathlib import Path
from typing import Any
from uuid import uuid4

import httpx

from tests.image.podman import PIPED, Podman
from tests.service.running import until

NPY = {"Content-Type": "application/x-npy"}


class Container:
    """One run of an `ipfit` command in an image. Settings are given by the name of the variable without IPFIT_."""

    def __init__(  # noqa: PLR0913 - what one may say to `podman run`
        self,
        podman: Podman,
        image: str,
        command: str,
        folder: Path,
        *,
        user: str = "12345:0",
        options: tuple[str, ...] = (),
        environment: dict[str, str] | None = None,
        **settings: object,
    ) -> None:
        self._podman, self._name = podman, f"ipfit-{uuid4().hex[:8]}"
        self._log = folder / f"{self._name}.log"
        port = free_port()
        usual = {"HOST": "127.0.0.1", "WORKERS": 1, "SHORT_WORKERS": 0, "SHUTDOWN_GRACE": 0}
        told = {f"IPFIT_{name}": value for name, value in (usual | settings).items()}
        told |= {"IPFIT_PORT" if command == "serve" else "IPFIT_PROBE_PORT": port, **(environment or {})}
        words = [f"--env={name}={value}" for name, value in told.items()]
        run = podman.run_command(image, command, user=user, options=(f"--name={self._name}", *words, *options))
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(run, stdin=subprocess.PIPE, stdout=log, stderr=subprocess.STDOUT)  # noqa: S603 - podman, with ours
        self.client = httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0)

    @property
    def log(self) -> str:
        return self._log.read_text(encoding="utf-8")

    def await_ready(self) -> None:
        until(self._ready, 90.0)

    def fit(self, content: bytes) -> dict[str, Any]:
        """Send an npy and return the fit, which must succeed."""
        answer = self.client.post("/v1/fits", content=content, headers=NPY | {"Prefer": "wait=60"})
        assert answer.status_code == 200, answer.text
        fit: dict[str, Any] = answer.json()
        assert fit["status"] == "successful", fit
        return fit

    def run(self, *words: str) -> str:
        """Run a program inside, beside the server, and return what it printed."""
        return self._podman("exec", PIPED, self._name, *words)

    def stop(self, seconds: float = 10.0) -> None:
        """Send SIGTERM, as every manager of containers does; it must exit with 0 at once."""
        self._process.send_signal(signal.SIGTERM)
        assert self._process.wait(seconds) == 0, self.log
        assert "Traceback" not in self.log, self.log

    def end(self) -> None:
        """End it if it still runs."""
        self.client.close()
        if self._process.poll() is None:
            self._podman("rm", "--force", "--time=0", self._name)
            self._process.wait(20.0)
        if self._process.stdin is not None:
            self._process.stdin.close()

    def ended(self, seconds: float = 60.0) -> int:
        """Return the exit status, as soon as it has ended by itself."""
        return self._process.wait(seconds)

    def _ready(self) -> bool:
        assert self._process.poll() is None, self.log
        try:
            return self.client.get("/readyz").is_success
        except httpx.TransportError:
            return False


def free_port() -> int:
    """Return a port that is free at this moment."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
    return port
