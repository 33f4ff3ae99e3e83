"""Clients that flood, stall or leave. Each is bounded in connections and time.

They run in a process of their own, `python -m load.attackers NAME PORT SECONDS`, which prints the statuses that it was
answered with as JSON. That process is nice: on a machine with few cores it must not win against the server by taking
the processor, as an attacker from another machine could not.
"""

import asyncio
import json
import os
import socket
import sys
from collections import Counter
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

from load import attack_requests as sent

ADDRESS = "127.0.0.3"
NICE = 10
CONNECT_TIMEOUT = 5.0
SECONDS_BETWEEN_BYTES = 0.2
SMALL_BUFFER = 4096


@dataclass
class Attack:
    """One attack that runs: where to, until when, and what was answered."""

    port: int
    end: float
    answers: Counter[str] = field(default_factory=Counter)

    @property
    def goes_on(self) -> bool:
        """Return whether there is time left."""
        return asyncio.get_running_loop().time() < self.end

    async def connected(self, *, small_buffer: bool = False) -> socket.socket:
        """Return a new connection from the attackers' address."""
        one = socket.socket()
        one.settimeout(0.0)
        one.bind((ADDRESS, 0))
        if small_buffer:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL_BUFFER)
        loop = asyncio.get_running_loop()
        try:
            await asyncio.wait_for(loop.sock_connect(one, ("127.0.0.1", self.port)), CONNECT_TIMEOUT)
        except BaseException:
            one.close()
            raise
        return one

    async def count(self, one: socket.socket) -> None:
        """Read until the server closes, and count the answers."""
        loop, tail = asyncio.get_running_loop(), b""
        while chunk := await loop.sock_recv(one, 1 << 18):
            *answers, tail = (tail + chunk).split(b"HTTP/1.1 ")
            for answer in answers:
                self.note(answer)
            tail = b"HTTP/1.1 " + tail[:64] if tail[:3].isdigit() else tail[-16:]
        self.note(tail.removeprefix(b"HTTP/1.1 "))

    def note(self, answer: bytes) -> None:
        """Count the status at the beginning of an answer, if there is one."""
        if answer[:3].isdigit():
            self.answers[answer[:3].decode()] += 1


async def hold(attack: Attack, first: bytes = b"", then: bytes = b"", *, small_buffer: bool = False) -> None:
    """Connect, send `first`, then `then` again and again, slowly, and read nothing."""
    loop = asyncio.get_running_loop()
    one = await attack.connected(small_buffer=small_buffer)
    try:
        await loop.sock_sendall(one, first)
        while attack.goes_on:
            await asyncio.sleep(SECONDS_BETWEEN_BYTES)
            if then:
                await loop.sock_sendall(one, then)
    finally:
        one.close()


async def flood(attack: Attack, block: bytes) -> None:
    """Send a block of requests again and again on one connection, as fast as the server takes it."""
    loop = asyncio.get_running_loop()
    one = await attack.connected()
    reading = asyncio.create_task(attack.count(one))
    try:
        while attack.goes_on and not reading.done():
            await loop.sock_sendall(one, block)
    finally:
        reading.cancel()
        one.close()


async def ask(attack: Attack, request: bytes) -> None:
    """Send one request on a connection of its own and read the answer."""
    one = await attack.connected()
    try:
        sending = asyncio.create_task(asyncio.get_running_loop().sock_sendall(one, request))
        await attack.count(one)  # the request closes the connection
        sending.cancel()
    finally:
        one.close()


async def leave(attack: Attack, request: bytes) -> None:
    """Send one request and close at once."""
    one = await attack.connected()
    try:
        await asyncio.get_running_loop().sock_sendall(one, request)
    finally:
        one.close()
        attack.answers["left"] += 1


Way = Callable[[Attack], Awaitable[None]]
# By name: how many do it at once, and what each of them does again and again.
ATTACKS: dict[str, tuple[int, Way]] = {
    "silent connections": (200, hold),
    "slow headers": (200, partial(hold, first=sent.HALF_HEAD, then=b"x")),
    "slow bodies": (200, partial(hold, first=sent.HALF_BODY, then=b"x")),
    "GET /livez pipelined, never read": (20, partial(hold, first=sent.LIVEZ * 2000, small_buffer=True)),
    "GET /livez pipelined on 1 connection": (1, partial(flood, block=sent.LIVEZ * 2000)),
    "GET /livez pipelined on 20 connections": (20, partial(flood, block=sent.LIVEZ * 2000)),
    "GET /livez on new connections": (20, partial(ask, request=sent.LIVEZ_ONCE)),
    "connections opened and closed": (20, partial(leave, request=b"")),
    "heads of 60 kB": (20, partial(flood, block=sent.LARGE_HEAD)),
    "bodies in chunks of 1 byte": (8, partial(flood, block=sent.SMALL_CHUNKS)),
    "bodies of 1 MB, not JSON in the end": (16, partial(ask, request=sent.BROKEN_JSON)),
    "bodies of 1 MB, points": (16, partial(ask, request=sent.MANY_POINTS)),
    "JSON of 200 kB with many keys": (16, partial(ask, request=sent.MANY_KEYS)),
    "JSON of 4 MB with many keys": (16, partial(ask, request=sent.MORE_KEYS)),
    "small fits, answered at once": (16, partial(ask, request=sent.SMALL_FIT)),
    "small fits, left at once": (16, partial(leave, request=sent.SMALL_FIT)),
}
# Those that need the id of a fit of a surface.
MESH_ATTACKS: dict[str, tuple[int, int, bool]] = {  # how many at once, resolution, whether they read
    "meshes at resolution 128": (16, 128, True),
    "meshes at resolution 256": (16, 256, True),
    "meshes that are never read": (50, 96, False),
}


def way(name: str, fit: str) -> tuple[int, Way]:
    """Return how many do what in the attack of this name."""
    if name in ATTACKS:
        return ATTACKS[name]
    count, resolution, reads = MESH_ATTACKS[name]
    if reads:
        return count, partial(ask, request=sent.mesh(fit, resolution, close=True))
    return count, partial(hold, first=sent.mesh(fit, resolution, close=False) * 4, small_buffer=True)


async def run(name: str, port: int, seconds: float, fit: str) -> Counter[str]:
    """Run an attack for so many seconds and return how often which status was answered."""
    count, each = way(name, fit)
    attack = Attack(port, asyncio.get_running_loop().time() + seconds)

    async def again_and_again() -> None:
        while attack.goes_on:
            try:
                await each(attack)
            except OSError as error:
                attack.answers[type(error).__name__] += 1
                await asyncio.sleep(SECONDS_BETWEEN_BYTES)

    with suppress(TimeoutError):
        async with asyncio.timeout(seconds + 1.0):
            await asyncio.gather(*(again_and_again() for _ in range(count)))
    return attack.answers


if __name__ == "__main__":
    os.nice(NICE)
    print(json.dumps(asyncio.run(run(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), sys.argv[4]))))
