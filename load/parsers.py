"""Compare what a request costs with each way to parse HTTP: uvicorn's two, and the guard of this service.

From the repository's root, with the environment of `make check`:

    python -m load.parsers

Each parser has a server of its own, in a process of its own, around an application that answers `ok` to everything.
One client sends requests over one connection, one after the other. The servers take turns, round after round; the table
has medians over the rounds, and is printed as Markdown. load/PARSERS.md has the last one.
"""

import socket
import statistics
import subprocess
import sys
import time
from typing import Any

import uvicorn

from service.connections.census import Census
from service.connections.limits import ConnectionLimits
from service.connections.protocol import guarded

PARSERS = {
    "httptools": "httptools",
    "httptools, guarded": guarded(ConnectionLimits(), Census(ConnectionLimits())),
    "h11": "h11",
}
HEAD = b"Host: x\r\nUser-Agent: load/1\r\nAccept: */*\r\nAccept-Encoding: gzip\r\n"
ROUNDS = 7


def post(size: int) -> bytes:
    """Return a request with a body of so many bytes."""
    return b"POST / HTTP/1.1\r\n" + HEAD + b"Content-Type: a/b\r\nContent-Length: %d\r\n\r\n" % size + bytes(size)


# By name: the request, and how many are sent in a round.
REQUESTS = {
    "GET": (b"GET / HTTP/1.1\r\n" + HEAD + b"\r\n", 2000),
    "POST, 20 kB": (post(20_000), 1000),
    "POST, 10 MB": (post(10_000_000), 5),
}


async def ok(_scope: Any, receive: Any, send: Any) -> None:  # noqa: ANN401 - an ASGI application
    """Read a request and answer it."""
    while (await receive()).get("more_body"):
        pass
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


def serve(parser: str) -> None:
    """Serve on a free port, which is printed."""
    listener = socket.create_server(("127.0.0.1", 0))
    print(listener.getsockname()[1], flush=True)
    config = uvicorn.Config(ok, http=PARSERS[parser], log_level="error", ws="none", lifespan="off")
    uvicorn.Server(config).run([listener])


def seconds(port: int, request: bytes, count: int) -> float:
    """Return how long one request takes, on average over a connection with so many."""
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        began = time.perf_counter()
        for _ in range(count):
            connection.sendall(request)
            answer = b""
            while not answer.endswith(b"ok"):
                answer += connection.recv(1 << 16)
        return (time.perf_counter() - began) / count


def main() -> None:
    """Run all servers and print the table."""
    command = [sys.executable, "-m", "load.parsers"]
    servers = {name: subprocess.Popen([*command, name], stdout=subprocess.PIPE) for name in PARSERS}  # noqa: S603 - ours
    try:
        ports = {name: int(one.stdout.readline()) for name, one in servers.items() if one.stdout is not None}
        print(f"| request | {' | '.join(ports)} |\n|{' --- |' * (1 + len(ports))}")
        for name, (request, count) in REQUESTS.items():
            rounds = [[seconds(port, request, count) for port in ports.values()] for _ in range(ROUNDS)]
            medians = map(statistics.median, zip(*rounds, strict=True))
            print(f"| {name} | {' | '.join(f'{1e6 * one:.0f} µs' for one in medians)} |")
    finally:
        for one in servers.values():
            one.kill()


if __name__ == "__main__":
    serve(sys.argv[1]) if sys.argv[1:] else main()
