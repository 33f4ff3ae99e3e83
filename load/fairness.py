"""Measure what a client with one fit at a time notices of another that has thousands of fits waiting.

From the repository's root, with the environment of `make check`:

    python -m load.fairness embedded
    python -m load.fairness cluster

The light client sends outlines of 500 points, one after the other; first it is alone with the server, then the heavy
client has thousands of the same waiting. The server runs with its default lanes. The table is printed as Markdown;
load/LOAD.md has the last ones.
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path

import httpx

from load.engines import ENGINES, running
from load.loops.answers import percentile
from load.loops.traffic import NPY, Request, outlines

HEAVY_FITS, SENDERS = 5000, 8
LIGHT_FITS, PAUSE = 100, 0.1  # seconds between an answer and the next fit
SETTINGS: dict[str, object] = {"SHORT_WORKERS": 1, "QUEUE_LIMIT": 2 * HEAVY_FITS, "FORWARDED_ALLOW_IPS": "*"}
LIGHT, HEAVY = "192.0.2.1", "192.0.2.2"  # addresses, as a proxy passes them on


@contextmanager
def client(port: int, address: str) -> Iterator[httpx.Client]:
    """Yield a client with an address of its own."""
    headers = {"Content-Type": NPY, "X-Forwarded-For": address}
    with httpx.Client(base_url=f"http://127.0.0.1:{port}", headers=headers, timeout=120.0) as made:
        yield made


def light(port: int) -> list[float]:
    """Send fits one after the other, and return the seconds that each took."""
    found = []
    with client(port, LIGHT) as caller:
        for _, one in zip(range(LIGHT_FITS), cycle(outlines()), strict=False):
            began = time.perf_counter()
            answer = caller.post(one.path, content=one.body, headers={"Prefer": "wait=100"}).raise_for_status()
            found.append(time.perf_counter() - began)
            if answer.json()["status"] != "successful":
                raise RuntimeError(answer.text[:300])
            time.sleep(PAUSE)
    return found


def fill(port: int, count: int) -> None:
    """Let the heavy client send so many fits without waiting for them."""

    def send(share: int) -> None:
        with client(port, HEAVY) as caller:
            for _, one in zip(range(share), cycle(outlines()), strict=False):
                submit(caller, one)

    with ThreadPoolExecutor(SENDERS) as senders:
        list(senders.map(send, [count // SENDERS] * SENDERS))


def submit(caller: httpx.Client, one: Request) -> None:
    """Send one fit without waiting for it."""
    caller.post(one.path, content=one.body, headers={"Prefer": "respond-async"}).raise_for_status()


def waiting(port: int) -> float:
    """Return how many fits wait."""
    with client(port, LIGHT) as caller:
        text = caller.get("/metrics").raise_for_status().text
    return sum(float(line.rpartition(" ")[2]) for line in text.splitlines() if _is_waiting(line))


def _is_waiting(line: str) -> bool:
    return line.startswith("ipfit_queue_fits{") and 'state="waiting"' in line


def main() -> None:
    """Measure one engine and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=ENGINES)
    engine = parser.parse_args().engine
    print("| engine | waiting of the other | light client: p50 | p95 | times alone: p50 | p95 |")
    print(f"|{' --- |' * 6}", flush=True)
    with (
        tempfile.TemporaryDirectory(prefix="ipfit-load-") as folder,
        running(engine, Path(folder), **SETTINGS) as started,
    ):
        light(started.port)  # each worker has then loaded all that it needs
        alone = light(started.port)
        print(row(engine, "0", alone, alone), flush=True)
        fill(started.port, HEAVY_FITS)
        before = waiting(started.port)
        beside = light(started.port)
        print(row(engine, f"{before:.0f} … {waiting(started.port):.0f}", beside, alone), flush=True)


def row(engine: str, others: str, found: list[float], alone: list[float]) -> str:
    """Return a row of the table."""
    both = [(percentile(found, percent), percentile(alone, percent)) for percent in (50, 95)]
    cells = [engine, others, *(f"{1000.0 * own:.0f} ms" for own, _ in both)]
    return f"| {' | '.join([*cells, *(f'{own / first:.2f}' for own, first in both)])} |"


if __name__ == "__main__":
    main()
