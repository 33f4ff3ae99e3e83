"""What every process that serves the API has: the use cases, their limits, and the context of the routes."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from service.api.dependencies import Context
from service.api.limits import Limits
from service.api.transit import Transit
from service.api.watch import Watch
from service.api_keys import ApiKeys
from service.bootstrap.fitting import FILE_POOL, UPLOAD_POOL, Pools, pool
from service.callbacks.addresses import AllowedAddresses
from service.callbacks.refused import NoCallbacks
from service.callbacks.sender import HttpSender
from service.callbacks.signature import Signer
from service.connections.limits import ConnectionLimits
from service.formats.exports import Exports
from service.formats.file_cache import FileCache
from service.formats.points.reader import PointSetReader
from service.jobs.callback_ports import CallbackRules, CallbackStore
from service.jobs.deliveries import Deliveries
from service.jobs.fit import MAX_CRASHES
from service.jobs.fit_files import FitFiles
from service.jobs.ports import FitQueue
from service.jobs.store_ports import BlobStore, FitStore
from service.jobs.use_cases import FitService
from service.settings import Settings
from service.workers.fair_seats import FairSeats
from service.workers.planner_adapter import FitPlanner

logger = logging.getLogger(__name__)

# Point sets that are read and stored at once: more only wait for each other, for the interpreter and for the disk.
ACCEPTED_AT_ONCE = 2


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
