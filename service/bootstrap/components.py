"""The components that an embedded server and a cluster both have."""

import asyncio
import os
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from uuid import uuid4

from service.api.limits import Limits
from service.callbacks.addresses import AllowedAddresses
from service.callbacks.refused import NoCallbacks
from service.callbacks.sender import HttpSender
from service.callbacks.signature import Signer
from service.connections.limits import ConnectionLimits
from service.formats.points.reader import PointSetReader
from service.formats.zero_set.exporter import MeshExporter
from service.jobs.callback_ports import CallbackRules, CallbackStore
from service.jobs.deliveries import Deliveries
from service.jobs.fit import MAX_CRASHES
from service.jobs.lease_holder import LeaseHolder
from service.jobs.ports import BlobStore, FitQueue, FitStore
from service.jobs.retention import Retention
from service.jobs.use_cases import FitService
from service.queue.runner import Runner, Tasks
from service.settings import Settings
from service.workers import tasks
from service.workers.planner_adapter import FitPlanner
from service.workers.pool import WorkerPool


@asynccontextmanager
async def pool(settings: Settings, size: int, tries: int = 1) -> AsyncIterator[WorkerPool]:
    """Yield a pool whose workers have started."""
    made = WorkerPool(size, settings.tasks_per_worker, settings.worker_memory, tries)
    try:
        await made.warm_up()
        yield made
    finally:
        await asyncio.to_thread(made.close)


@asynccontextmanager
async def fitters(settings: Settings) -> AsyncIterator[WorkerPool]:
    """Yield the pool in which fits run, with a worker for each fit that may run at once."""
    async with pool(settings, settings.workers + settings.short_workers) as made:
        yield made


def runner(settings: Settings, store: FitStore, blobs: BlobStore, workers: WorkerPool, *, publish: bool) -> Runner:
    """Return the runner of fits in these workers."""
    name = f"{socket.gethostname()}-{os.getpid()}-{uuid4().hex[:8]}"
    holder = LeaseHolder(name, settings.lease)
    work = Tasks(tasks.fit, tasks.sum_moments, tasks.fit_from_moments)
    return Runner(store, blobs, workers, work, holder=holder, deadline=settings.fit_deadline, publish=publish)


@asynccontextmanager
async def fit_service(
    settings: Settings, store: FitStore, blobs: BlobStore, queue: FitQueue, callbacks: CallbackRules
) -> AsyncIterator[FitService]:
    """Yield the use cases, with a worker of their own that reads bodies and exports zero sets while fits run."""
    async with pool(settings, 1, tries=MAX_CRASHES) as readers:
        reader = PointSetReader(readers, settings.max_points, settings.mesh_deadline)
        exporter = MeshExporter(readers, settings.mesh_deadline)
        yield FitService(
            store,
            blobs,
            queue,
            reader,
            exporter,
            planner=FitPlanner(),
            callbacks=callbacks,
            split_points=settings.split_points,
        )


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


def connection_limits(settings: Settings) -> ConnectionLimits:
    """Return the limits on the connections of this process."""
    return ConnectionLimits.for_process(
        head_seconds=settings.head_timeout,
        stall_seconds=settings.stall_timeout,
        connections=settings.max_connections,
        trusted=frozenset(part.strip() for part in settings.forwarded_allow_ips.split(",")),
    )
