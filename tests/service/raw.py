"""Raw connections to a server: any bytes, at any pace."""

import json
import socket
import time
from dataclasses import dataclass
from typing import Any

from tests.service.running import Server


@dataclass(frozen=True)
class Answer:
    """What came back until the server closed: status, headers in lower case, body; status 0 without an answer."""

    status: int
    headers: dict[str, str]
    body: bytes
    seconds: float

    @property
    def problem(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.body)
        return found


def connected(server: Server) -> socket.socket:
    host, port = server.url.removeprefix("http://").split(":")
    return socket.create_connection((host, int(port)), timeout=20.0)


def talk(server: Server, *pieces: bytes, pause: float = 0.0) -> Answer:
    """Send pieces with pauses between them, and read until the server closes."""
    began, received = time.monotonic(), b""
    with connected(server) as connection:
        try:
            for piece in pieces:
                connection.sendall(piece)
                time.sleep(pause)
        except OSError:
            pass  # the server has closed: what it said is still to be read
        try:
            while chunk := connection.recv(65536):
                received += chunk
        except OSError:
            pass
    head, _, body = received.partition(b"\r\n\r\n")
    if not head:
        return Answer(0, {}, b"", time.monotonic() - began)
    status, *lines = head.decode("latin-1").split("\r\n")
    headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    return Answer(int(status.split()[1]), headers, body, time.monotonic() - began)
