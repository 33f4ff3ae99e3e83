"""What every process that runs fits has: its pools of workers, the runner of fits, and what supervisors are told."""

import asyncio
import os
import socket
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import asynccontextmanager
from uuid import uuid4

from service.api.watch import Watch
from service.bootstrap import memory
from service.jobs.admission import Admission
from service.jobs.lane_load import LaneLoad
from service.jobs.lease_holder import LeaseHolder
from service.jobs.observer import FitObserver
from service.jobs.retention import Retention
from service.jobs.store_ports import BlobStore, FitStore
from service.queue.runner import Runner
from service.queue.work import Lanes, Tasks
from service.settings import Settings
from service.telemetry.exposition import Exposition
from service.telemetry.gauges import Gauges
from service.telemetry.metrics import Metrics
from service.workers import tasks
from service.workers.canary import Canary
from service.workers.pool import WorkerPool

# By how much the priority of workers is lower than that of the server, which has little to do and whom everybody waits
# for; 19 is the most. The lane of short fits has its own: whoever sends one fit waits there, beside floods of others.
NICENESS, SHORT_NICENESS = 10, 0
# The names of the pools of workers, in metrics and messages.
FIT_POOL, SHORT_FIT_POOL, UPLOAD_POOL, FILE_POOL = "fits", "short fits", "uploads", "files"
Pools = dict[str, WorkerPool]  # by name, for the metrics


@asynccontextmanager
async def pool(  # noqa: PLR0913 - how it is made, and under which name
    settings: Settings, pools: Pools, name: str, size: int, *, tries: int = 1, niceness: int = NICENESS
) -> AsyncIterator[WorkerPool]:
    """Yield a pool whose workers have started, and add it to `pools`."""
    made = pools[name] = WorkerPool(size, settings.tasks_per_worker, memory_of_a_worker(settings), tries, niceness)
    try:
        await made.warm_up()
        yield made
    finally:
        await asyncio.to_thread(made.close)


def memory_of_a_worker(settings: Settings) -> int:
    """Return the bytes that a worker process may take."""
    processes = settings.workers + settings.short_workers + settings.mesh_workers + 1
    return settings.worker_memory or memory.worker_memory(processes, settings.server_memory)


@asynccontextmanager
async def fitters(settings: Settings, pools: Pools) -> AsyncIterator[Lanes]:
    """Yield the pools in which fits run, with a worker for each fit that may run at once."""
    async with pool(settings, pools, FIT_POOL, settings.workers) as made:
        if not settings.short_workers:
            yield Lanes(made, made)
            return
        async with pool(settings, pools, SHORT_FIT_POOL, settings.short_workers, niceness=SHORT_NICENESS) as short:
            yield Lanes(made, short)


@asynccontextmanager
async def watch(
    metrics: Metrics, pools: Pools, load: Callable[[], Iterable[LaneLoad]], check: Callable[[], Awaitable[None]]
) -> AsyncIterator[Watch]:
    """Yield what supervisors of this process are told, and try whether its workers can fit, again and again.

    A process without workers for fits tries those that read uploads.
    """
    metrics.add(Gauges(pools, load))
    canary = Canary([pools[name] for name in (FIT_POOL, SHORT_FIT_POOL) if name in pools] or [pools[UPLOAD_POOL]])

    async def check_ready() -> None:
        await check()
        canary.check()

    exposition = Exposition(metrics.registry)
    trying = asyncio.create_task(canary.keep_trying())
    try:
        yield Watch(check_ready, exposition, metrics)
    finally:
        exposition.close()
        trying.cancel()
        await asyncio.gather(trying, return_exceptions=True)


def runner(  # noqa: PLR0913 - what it runs, where, and who is told
    settings: Settings, store: FitStore, blobs: BlobStore, lanes: Lanes, observer: FitObserver, *, publish: bool
) -> Runner:
    """Return the runner of fits in these workers."""
    name = f"{socket.gethostname()}-{os.getpid()}-{uuid4().hex[:8]}"
    holder = LeaseHolder(name, settings.lease)
    work = Tasks(tasks.fit, tasks.sum_moments, tasks.fit_from_moments)
    return Runner(
        store,
        blobs,
        lanes,
        work,
        holder=holder,
        deadline=settings.fit_deadline,
        publish=publish,
        observer=observer,
    )


def admission(settings: Settings) -> Admission:
    """Return the limits of the queue."""
    return Admission(settings.queue_limit, settings.queue_bytes, settings.client_share)


def retention(settings: Settings, store: FitStore, blobs: BlobStore) -> Retention:
    """Return the removal of old fits; in a data folder, which only one server uses, also of orphaned point sets."""
    exclusive = settings.database_url is None and settings.blobs_url is None
    return Retention(store, blobs, settings.keep_seconds, settings.keep_bytes, exclusive=exclusive)
