"""An S3 over HTTP in a process of its own (moto's server), which can be stopped and killed."""

import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress

import httpx

BUCKET = "ipfit"


class S3:
    """One S3 server, always at the same address. It loses its content when it is killed."""

    def __init__(self) -> None:
        with socket.socket() as one:
            one.bind(("127.0.0.1", 0))
            self._port: int = one.getsockname()[1]
        self.start()

    @property
    def environment(self) -> dict[str, str]:
        """Return the AWS variables by which other processes find it."""
        return {
            "AWS_ENDPOINT_URL": f"http://127.0.0.1:{self._port}",
            "AWS_ACCESS_KEY_ID": "test",
            "AWS_SECRET_ACCESS_KEY": "test",
            "AWS_DEFAULT_REGION": "us-east-1",
        }

    def start(self) -> None:
        """Start, with an empty bucket."""
        command = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(self._port)]
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # noqa: S603 - ours
        end = time.monotonic() + 60.0
        while True:
            with suppress(httpx.TransportError):
                httpx.put(f"{self.environment['AWS_ENDPOINT_URL']}/{BUCKET}").raise_for_status()
                return
            assert time.monotonic() < end, "the S3 does not start"
            time.sleep(0.05)

    def hang(self) -> None:
        """Accept connections and answer nothing."""
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        self._process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        self._process.kill()
        self._process.wait(10.0)
