"""Compare fits over HTTP with the same fits in processes of their own, in one run.

From the repository's root, with the environment of `make check`:

    python -m load.overhead embedded
    python -m load.overhead cluster

*Throughput*: two processes that fit one outline after another, without HTTP; then eight clients of a server with two
workers; in turns, round after round. *Time of one request*: one client, and the same fit in one process, in turns. The
tables have medians over the rounds, and are printed as Markdown. load/LOAD.md has the last ones.
"""

import argparse
import http.client
import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from itertools import cycle
from multiprocessing import get_context
from multiprocessing.pool import Pool
from pathlib import Path

import numpy as np
import orjson

import ipcore
from load.engines import ENGINES, running
from load.loops.traffic import outlines
from service.workers.fork_server import BLAS_THREADS
from tests.service.bodies import npy, torus
from tests.service.running import ticks

PROCESSES, CLIENTS = 2, 8
ROUNDS, SECONDS = 7, 4.0
LATENCY_ROUNDS = 30


THROUGHPUT = {f"outlines of {count} points": [one.body for one in outlines(count)] for count in (60, 500)}
LATENCY = THROUGHPUT | {"torus of 100,000 oriented points": [npy(torus(100_000))]}


def fit(body: bytes) -> bytes:
    """Fit a body as a worker does: from an npy to the JSON of the result."""
    table = np.load(BytesIO(body))
    dimension = min(table.shape[1], 3)
    points, normals = table[:, :dimension], table[:, dimension:]
    return orjson.dumps(ipcore.fit(points, normals if normals.size else None).to_dict())


def rate(fit_one: Callable[[bytes], object], bodies: list[bytes], seconds: float) -> tuple[int, float]:
    """Fit one body after another for so many seconds; return how many were fitted, and in which time."""
    began, count = time.perf_counter(), 0
    for body in cycle(bodies):
        fit_one(body)
        count += 1
        if time.perf_counter() - began >= seconds:
            break
    return count, time.perf_counter() - began


def rate_alone(bodies: list[bytes], seconds: float) -> float:
    """Return the fits per second of this process."""
    count, took = rate(fit, bodies, seconds)
    return count / took


def rate_over_http(port: int, bodies: list[bytes], seconds: float) -> float:
    """Return the fits per second of one client."""
    count, took = rate(Client(port).fit, bodies, seconds)
    return count / took


class Client:
    """A client with one connection."""

    def __init__(self, port: int) -> None:
        self._connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60.0)

    def fit(self, body: bytes) -> bytes:
        """Send a body, wait for its fit and return the answer."""
        self._connection.request("POST", "/v1/fits", body, {"Content-Type": "application/x-npy"})
        answer = self._connection.getresponse()
        content = answer.read()
        if answer.status != http.client.OK:
            raise RuntimeError(f"{answer.status}: {content[:300]!r}")
        return content


def seconds_of(fit_one: Callable[[bytes], object], body: bytes) -> float:
    """Return how long one fit takes."""
    began = time.perf_counter()
    fit_one(body)
    return time.perf_counter() - began


@contextmanager
def processes(count: int) -> Iterator[Pool]:
    """Yield processes that have loaded the library, with one thread each, as a server's workers have."""
    os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
    with get_context("spawn").Pool(count) as pool:
        pool.map(fit, LATENCY["outlines of 60 points"][:1] * 4 * count, chunksize=1)
        yield pool


def throughput(port: int, pids: list[int], name: str) -> str:
    """Return the row of a kind of outlines."""
    bodies, alone, over_http, used = THROUGHPUT[name], [], [], []
    with processes(PROCESSES) as fitters, processes(CLIENTS) as clients:
        for _ in range(ROUNDS):
            alone.append(sum(fitters.starmap(rate_alone, [(bodies, SECONDS)] * PROCESSES, chunksize=1)))
            before = [ticks(pid) for pid in pids]
            asked = [(port, bodies, SECONDS)] * CLIENTS
            over_http.append(sum(clients.starmap(rate_over_http, asked, chunksize=1)))
            ticked = [ticks(pid) - at for pid, at in zip(pids, before, strict=True)]
            used.append([1000.0 * one / os.sysconf("SC_CLK_TCK") / (over_http[-1] * SECONDS) for one in ticked])
    ratio = statistics.median(http / own for http, own in zip(over_http, alone, strict=True))
    cost = " + ".join(f"{statistics.median(one):.1f}" for one in zip(*used, strict=True))
    return (
        f"| {name} | {statistics.median(alone):.1f} | {statistics.median(over_http):.1f} | {100.0 * ratio:.0f} % "
        f"| {cost} ms |"
    )


def latency(port: int, name: str) -> str:
    """Return the row of a kind of point sets."""
    bodies, alone, over_http = LATENCY[name], [], []
    client = Client(port)
    with processes(1) as fitter:
        for _, body in zip(range(LATENCY_ROUNDS), cycle(bodies), strict=False):
            alone.append(fitter.apply(seconds_of, (fit, body)))
            over_http.append(seconds_of(client.fit, body))
    more = [http - own for http, own in zip(over_http, alone, strict=True)]
    cells = [f"{1000.0 * statistics.median(one):.1f} ms" for one in (alone, over_http, more)]
    return f"| {name} | {' | '.join(cells)} |"


def main() -> None:
    """Measure one engine and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=ENGINES)
    arguments = parser.parse_args()
    with (
        tempfile.TemporaryDirectory(prefix="ipfit-load-") as folder,
        running(arguments.engine, Path(folder), WORKERS=PROCESSES) as engine,
    ):
        print("| eight clients | fits/s alone | over HTTP | share | processor time of a fit outside the worker |")
        print(f"|{' --- |' * 5}")
        for name in THROUGHPUT:
            print(throughput(engine.port, engine.supervisors, name), flush=True)
        print("\n| one client | alone | over HTTP | more |")
        print(f"|{' --- |' * 4}")
        for name in LATENCY:
            print(latency(engine.port, name), flush=True)


if __name__ == "__main__":
    main()
