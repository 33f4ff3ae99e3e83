"""The components that an embedded server and a cluster both have."""

import asyncio
import logging
import os
import socket
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import asynccontextmanager
from pathlib import Path
from uuid import uuid4

from service.api.dependencies import Context
from service.api.limits import Limits
from service.api.transit import Transit
from service.api.watch import Watch
from service.api_keys import ApiKeys
from service.bootstrap import memory
from service.callbacks.addresses import AllowedAddresses
from service.callbacks.refused import NoCallbacks
from service.callbacks.sender import HttpSender
from service.callbacks.signature import Signer
from service.connections.limits import ConnectionLimits
from service.formats.exports import Exports
from service.formats.file_cache import FileCache
from service.formats.points.reader import PointSetReader
from service.jobs.admission import Admission
from service.jobs.callback_ports import CallbackRules, CallbackStore
from service.jobs.deliveries import Deliveries
from service.jobs.fit import MAX_CRASHES
from service.jobs.fit_files import FitFiles
from service.jobs.lane_load import LaneLoad
from service.jobs.lease_holder import LeaseHolder
from service.jobs.observer import FitObserver
from service.jobs.ports import FitQueue
from service.jobs.retention import Retention
from service.jobs.store_ports import BlobStore, FitStore
from service.jobs.use_cases import FitService
from service.queue.runner import Runner
from service.queue.work import Lanes, Tasks
from service.settings import Settings
from service.telemetry.exposition import Exposition
from service.telemetry.gauges import Gauges
from service.telemetry.metrics import Metrics
from service.workers import tasks
from service.workers.canary import Canary
from service.workers.fair_seats import FairSeats
from service.workers.planner_adapter import FitPlanner
from service.workers.pool import WorkerPool

logger = logging.getLogger(__name__)

# Point sets that are read and stored at once: more only wait for each other, for the interpreter and for the disk.
ACCEPTED_AT_ONCE = 2
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


@asynccontextmanager
async def use_cases(  # noqa: PLR0913, PLR0917 - the parts from which it is made
    settings: Settings,
    store: FitStore,
    blobs: BlobStore,
    queue: FitQueue,
    callbacks: CallbackRules,
    files: Path,
    pools: Pools,
) -> AsyncIterator[tuple[FitService, FitFiles]]:
    """Yield the use cases, with workers of their own that read bodies, and that make files in the folder `files`.

    They work while fits run, and neither do uploads wait for meshes nor meshes for uploads.
    """
    deadline, places = settings.mesh_deadline, settings.waiting_requests
    async with (
        pool(settings, pools, UPLOAD_POOL, 1, tries=MAX_CRASHES) as readers,
        pool(settings, pools, FILE_POOL, settings.mesh_workers, tries=MAX_CRASHES) as makers,
    ):
        reading = FairSeats(UPLOAD_POOL, 1, places, deadline)
        making = FairSeats(FILE_POOL, settings.mesh_workers, places, deadline)
        cache = FileCache(files, settings.mesh_cache_bytes)
        fits = FitService(
            store,
            blobs,
            queue,
            PointSetReader(readers, reading, settings.max_points, deadline),
            planner=FitPlanner(),
            callbacks=callbacks,
            split_points=settings.split_points,
        )
        yield fits, FitFiles(fits, Exports(makers, making, cache, blobs, deadline, settings.max_mesh_bytes))


def admission(settings: Settings) -> Admission:
    """Return the limits of the queue."""
    return Admission(settings.queue_limit, settings.queue_bytes, settings.client_share)


@asynccontextmanager
async def callbacks(settings: Settings, store: CallbackStore) -> AsyncIterator[CallbackRules]:
    """Deliver callbacks, if there is a secret to sign them with, and yield the rules for new ones."""
    if settings.callback_secret is None:
        yield NoCallbacks()
        return
    sender = HttpSender(
        Signer.of(settings.callback_secret.get_secret_value()),
        AllowedAddresses.of(settings.callback_allow_private),
        allow_http=settings.callback_allow_http,
    )
    deliveries = Deliveries(store, sender, f"{settings.root_path}/v1/fits")
    delivering = asyncio.create_task(deliveries.keep_delivering())
    try:
        yield sender
    finally:
        delivering.cancel()
        await asyncio.gather(delivering, return_exceptions=True)


def retention(settings: Settings, store: FitStore, blobs: BlobStore) -> Retention:
    """Return the removal of old fits; in a data folder, which only one server uses, also of orphaned point sets."""
    exclusive = settings.database_url is None and settings.blobs_url is None
    return Retention(store, blobs, settings.keep_seconds, settings.keep_bytes, exclusive=exclusive)


def limits(settings: Settings) -> Limits:
    """Return the limits on a request."""
    return Limits(
        body_bytes=settings.max_body_bytes,
        max_degree={2: settings.max_degree_2d, 3: settings.max_degree_3d},
        resolution={2: settings.max_resolution_2d, 3: settings.max_resolution_3d},
        system_bytes=settings.max_system_bytes,
        wait=settings.max_wait,
    )


def context(settings: Settings, fits: FitService, files: FitFiles, incoming: Path, watch: Watch) -> Context:
    """Return the context of the routes."""
    keys = None if settings.api_keys is None else ApiKeys.read(settings.api_keys)
    if keys is None:
        logger.warning("everybody who reaches this server may use it: there are no API keys (IPFIT_API_KEYS)")
    else:
        logger.info("%d API keys were read", len(keys.callers))
    turns = FairSeats("point sets", ACCEPTED_AT_ONCE, settings.queue_limit, settings.mesh_deadline)
    return Context(fits, files, limits(settings), incoming, turns, Transit(settings.transit_bytes), watch, keys)


def connection_limits(settings: Settings) -> ConnectionLimits:
    """Return the limits on the connections of this process."""
    return ConnectionLimits.for_process(
        head_seconds=settings.head_timeout,
        stall_seconds=settings.stall_timeout,
        connections=settings.max_connections,
        trusted=frozenset(part.strip() for part in settings.forwarded_allow_ips.split(",")),
    )
