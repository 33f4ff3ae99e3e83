"""Measure the queue of a cluster without the fits: how many jobs a second it passes on, and how soon a worker starts.

From the repository's root, with the environment of `make check`:

    python -m load.queue_cost

*Jobs*: fits are stored with their jobs, and workers take, start and end them as always, but the fit itself is a
constant: what is left is the cost of the queue. Each worker is a process of its own with one seat. *Start*: `ipfit
worker` beside an empty database and beside one with a million ended fits, from the command to the start of a fit that
waits. The tables are printed as Markdown; load/LOAD.md has the last ones.
"""

import argparse
import asyncio
import signal
import statistics
import tempfile
import time
from datetime import UTC, datetime
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any
from uuid import uuid4

import psycopg

from service.jobs.admission import Admission
from service.jobs.fit import Fit, FitStatus, PointSetRef
from service.jobs.lease_holder import LeaseHolder
from service.jobs.requested_options import RequestedOptions
from service.queue.procrastinate_jobs import ProcrastinateJobs
from service.queue.procrastinate_worker import ProcrastinateWorker
from service.queue.runner import Runner
from service.queue.work import Lanes, Tasks
from service.store.blobs import Blobs
from service.store.engines import postgres_engine
from service.store.fits import SqlFits
from service.workers import tasks
from tests.service.bodies import ellipse, npy
from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.running import until
from tests.service.stores import QUEUE

JOBS, WORKERS = 3000, (1, 8, 32)
STARTING = 300.0  # seconds in which all workers must have started
CONNECTIONS = 500  # of PostgreSQL; a worker holds six or more
ENDED, STARTS = 1_000_000, 5
# A row of a fit that has ended long ago, with a result of the usual size of a plane curve.
FILL = """
INSERT INTO fits (id, status, input, dimension, points, options, client, cost, payload, created, touched, started,
                  finished, size, result, attempt, crashes, abandoned, parts, unsummed)
SELECT 'ended-' || n, 'successful', md5(n::text), 2, 500, '{}', '192.0.2.' || n %% 250, 0.1, md5(n::text), moment,
       moment, moment, moment, 5000, convert_to(repeat(md5(n::text), 60), 'utf8'), 1, 0, 0, 0, 0
FROM (SELECT n, now() - n * interval '0.5 s' AS moment FROM generate_series(1, %(count)s) AS n) AS ended
"""


class Constant:
    """Workers that have the answer already."""

    async def run(self, *_arguments: object, **_limits: object) -> Any:  # noqa: ANN401 - of any function
        """Return a result that says nothing."""
        return b"{}"


def store_at(url: str) -> SqlFits:
    """Return the store in a database."""
    return SqlFits(postgres_engine(url, QUEUE), Admission(10**9), ProcrastinateJobs())


def new_fit(number: int) -> Fit:
    """Return a fit of one of eight clients."""
    given = PointSetRef("0" * 64, 2, 500)
    return Fit(uuid4().hex, FitStatus.ACCEPTED, given, RequestedOptions({}), datetime.now(UTC), f"{number % 8}", 0.1)


def work(url: str, together: Barrier) -> None:
    """Take jobs with one seat, when all workers can, until SIGTERM."""
    store, workers = store_at(url), Constant()
    lanes, functions = Lanes(workers, workers), Tasks(tasks.fit, tasks.sum_moments, tasks.fit_from_moments)
    holder = LeaseHolder(uuid4().hex, 60.0)
    runner = Runner(store, Blobs("memory://"), lanes, functions, holder=holder, deadline=60.0, publish=True)
    worker = ProcrastinateWorker(store, runner, lambda: False, url=url, seats=1, short_seats=0, lease=60.0)

    async def until_stopped() -> None:
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, worker.stop)
        together.wait(STARTING)
        await worker.work(1.0)

    asyncio.run(until_stopped())


def jobs_a_second(postgres: Postgres, count: int) -> float:
    """Return how many jobs a second so many workers end, from the first start to the last end."""
    url = postgres.database()
    store = store_at(url)
    for number in range(JOBS):
        store.add(new_fit(number), list)
    context = get_context("spawn")
    together = context.Barrier(count)
    processes = [context.Process(target=work, args=(url, together)) for _ in range(count)]
    for one in processes:
        one.start()
    until(lambda: not store.count_waiting(), 600.0)
    time.sleep(1.0)
    for one in processes:
        one.terminate()
    for one in processes:
        one.join()
    with psycopg.connect(url) as connection:
        ((ended, seconds),) = connection.execute(
            "SELECT count(*), extract(epoch FROM max(finished) - min(started)) FROM fits WHERE status = 'successful'"
        )
    if ended != JOBS:
        raise RuntimeError(f"{ended} of {JOBS} jobs ended well")
    return JOBS / float(seconds)


def seconds_to_start(cluster: Cluster) -> float:
    """Return the seconds from the command `ipfit worker` to the start of a fit that waits."""
    server = cluster.servers[0]
    fit = server.fit(npy(ellipse()), prefer="respond-async")
    began = time.monotonic()
    worker = cluster.work()
    until(lambda: server.look(fit)["status"] != "accepted", 120.0)
    took = time.monotonic() - began
    server.look(fit, wait=60)
    worker.stop()
    return took


def starts(postgres: Postgres, ended: int) -> str:
    """Return the row of starts beside so many ended fits."""
    with tempfile.TemporaryDirectory(prefix="ipfit-load-") as folder:
        cluster = Cluster(Path(folder), postgres)
        try:
            cluster.serve()
            with psycopg.connect(cluster.database, autocommit=True) as connection:
                connection.execute(FILL, {"count": ended})
                connection.execute("VACUUM ANALYZE fits")
            took = [seconds_to_start(cluster) for _ in range(STARTS)]
        finally:
            cluster.end()
    return f"| {ended:,} | {statistics.median(took):.2f} s | {min(took):.2f} … {max(took):.2f} s |"


def main() -> None:
    """Measure and print the tables."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    postgres = Postgres(max_connections=str(CONNECTIONS))
    try:
        print("| workers | jobs/s |\n| --- | --- |")
        for count in WORKERS:
            print(f"| {count} | {jobs_a_second(postgres, count):.0f} |", flush=True)
        print("\n| ended fits | a worker starts a fit after | of so many starts |\n| --- | --- | --- |")
        for ended in (0, ENDED):
            print(starts(postgres, ended), flush=True)
    finally:
        postgres.remove()


if __name__ == "__main__":
    main()
