"""The use cases: read, accept, look up, wait, draw, dismiss."""

import asyncio
import hashlib
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar
from uuid import uuid4

import orjson

import ipcore
from service.jobs.errors import (
    FitNotFinishedError,
    FitNotFoundError,
    FitWithoutResultError,
    JobError,
    NotReadyError,
    ShuttingDownError,
)
from service.jobs.fit import Fit, FitStatus, PointSet, PointSetRef
from service.jobs.mesh_request import MeshRequest
from service.jobs.parts import split
from service.jobs.ports import BlobStore, FitQueue, FitStore, MeshExporter, Planner, Reader
from service.jobs.requested_options import RequestedOptions

T = TypeVar("T")


class FitService:
    """What a caller can have done with fits. Blocking stores are called in threads, so the event loop never waits."""

    def __init__(  # noqa: PLR0913 - six ports, one setting
        self,
        store: FitStore,
        blobs: BlobStore,
        queue: FitQueue,
        reader: Reader,
        exporter: MeshExporter,
        *,
        planner: Planner,
        split_points: int,
    ) -> None:
        """Work with these parts; split fits of more points than that, if sums over them will do."""
        self._store, self._blobs, self._queue = store, blobs, queue
        self._reader, self._exporter, self._planner, self._split_points = reader, exporter, planner, split_points

    async def read(self, body: bytes | Path, kind: str) -> PointSet:
        """Read and check a body; nothing is accepted yet."""
        return await self._reader.read(body, kind)

    def plan(self, points: PointSet, requested: RequestedOptions) -> ipcore.Plan:
        """Return what a fit will take; nothing is accepted yet.

        Raises
        ------
        InvalidInputError
            If the options are not allowed for points of this dimension.

        """
        return self._planner.plan(points, requested.complete)

    async def accept(
        self,
        points: PointSet,
        requested: RequestedOptions,
        plan: ipcore.Plan,
        client: str = "",
        key: str | None = None,
    ) -> Fit:
        """Store a fit and see that it is run. When this returns, it survives a crash.

        Parameters
        ----------
        points, requested
            The point set and the options.
        plan
            What `plan` returned for them.
        client
            Who sent it.
        key
            Idempotency key: of two calls with one key, the second returns the fit of the first.

        Raises
        ------
        NotReadyError, ShuttingDownError, QueueFullError
            If it cannot be stored, the server is about to stop, or too many fits wait.
        KeyReusedError
            If the key came with another point set or other options.

        """
        self._refuse_when_stopping()
        new, parts = _new_fit(points, requested, plan, client, key), list[Fit]()
        if points.frame is not None and points.points > self._split_points and plan.summable:
            new, parts = split(new, points.frame, self._split_points)
        fit = await self._add(new, points.content, parts)
        if fit.id == new.id:
            for one in parts or [fit]:
                self._queue.submit(one)
        return fit

    async def _add(self, new: Fit, content: bytes, parts: list[Fit]) -> Fit:
        """Store a fit with its input; if it cannot be stored, leave no input that takes the last room on the disk."""
        try:
            return await _asked(self._store.add, new, lambda: self._blobs.put(content), parts)
        except NotReadyError:
            with suppress(Exception):
                await asyncio.to_thread(self._store.discard, new.input.key, self._blobs.delete)
            raise

    async def get(self, fit_id: str, wait: float = 0.0) -> Fit:
        """Return a fit, after at most `wait` seconds if it is still live.

        Raises
        ------
        FitNotFoundError
            If there is none.
        NotReadyError
            If the store fails.

        """
        fit = await self._get(fit_id)
        if wait > 0.0 and not fit.status.final:
            await self._queue.wait(fit_id, wait)
            fit = await self._get(fit_id)
        return fit

    async def progress(self, fit: Fit) -> list[dict[str, Any]]:
        """Return the degrees that a running fit has tried so far."""
        return [] if fit.status.final else await self._queue.progress(fit.id)

    async def zero_set(self, fit_id: str, wanted: MeshRequest) -> bytes:
        """Return the file of the zero set of a successful fit.

        Raises
        ------
        FitNotFinishedError, FitWithoutResultError
            If it has no result yet, or will never have one.

        """
        fit = await self._get(fit_id)
        if not fit.status.final:
            raise FitNotFinishedError(f"fit {fit_id} is {fit.status}; its zero set can be drawn when it is successful")
        if fit.result is None:
            raise FitWithoutResultError(f"fit {fit_id} is {fit.status} and has no zero set")
        try:
            points = await _asked(self._blobs.get, fit.input.key)
        except NotReadyError:
            await self._get(fit_id)  # which says so, if the fit was removed in this very moment
            raise
        return await self._exporter.export(fit.result, points, fit.input.dimension, wanted)

    async def check(self) -> None:
        """Return if fits can be stored and run.

        Raises
        ------
        NotReadyError, ShuttingDownError
            If the store fails, or the server is about to stop.

        """
        self._refuse_when_stopping()
        await _asked(self._store.count_waiting)

    async def dismiss(self, fit_id: str) -> Fit | None:
        """Dismiss a live fit, killing its worker, and return it; or remove one that has ended, and return None."""
        await self._get(fit_id)
        if await _asked(self._store.dismiss, fit_id):
            self._queue.cancel(fit_id)
            return await self._get(fit_id)
        await _asked(self._store.remove, fit_id, self._blobs.delete)
        return None

    async def drain(self, seconds: float) -> None:
        """Accept nothing more, let what runs end in so much time, and answer those who wait with what is known then."""
        await self._queue.drain(seconds)

    def hurry(self) -> None:
        """End a drain at once."""
        self._queue.hurry()

    def _refuse_when_stopping(self) -> None:
        if self._queue.stopping:
            raise ShuttingDownError("the server is stopping; try again when it is back")

    async def _get(self, fit_id: str) -> Fit:
        fit = await _asked(self._store.get, fit_id)
        if fit is None or fit.whole is not None:  # a part is nobody's business
            raise FitNotFoundError(f"there is no fit {fit_id[:40]}")
        return fit


async def _asked(call: Callable[..., T], *arguments: object) -> T:
    """Call the store in a thread. Whatever goes wrong there, a full disk or a database that is away, may pass."""
    try:
        return await asyncio.to_thread(call, *arguments)
    except JobError:
        raise
    except Exception as error:
        raise NotReadyError(f"fits cannot be stored or looked up at the moment: {type(error).__name__}") from error


def _new_fit(points: PointSet, requested: RequestedOptions, plan: ipcore.Plan, client: str, key: str | None) -> Fit:
    blob = hashlib.sha256(points.content).hexdigest()
    payload = orjson.dumps([blob, points.dimension, requested.given], option=orjson.OPT_SORT_KEYS)
    return Fit(
        id=uuid4().hex,
        status=FitStatus.ACCEPTED,
        input=PointSetRef(blob, points.dimension, points.points, len(points.content)),
        requested=requested,
        created=datetime.now(UTC),
        client=client,
        cost=plan.seconds,
        key=key,
        payload=hashlib.sha256(payload).hexdigest(),
    )
