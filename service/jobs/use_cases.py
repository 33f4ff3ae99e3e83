"""The use cases: read a point set, accept a fit, look it up, wait for it, list, dismiss and remove it."""

import asyncio
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import ipcore
from service.jobs.accepted import Accepted
from service.jobs.admission import Usage
from service.jobs.callback_ports import CallbackRules
from service.jobs.caller import Caller, Quota
from service.jobs.errors import (
    FitNotFoundError,
    NotReadyError,
    QueueFullError,
    QuotaExceededError,
    ShuttingDownError,
)
from service.jobs.fit import Fit, ReceivedPoints
from service.jobs.new_fit import new_fit
from service.jobs.page import Page
from service.jobs.parts import split
from service.jobs.ports import FitQueue, Planner, Reader
from service.jobs.read_request import ReadRequest
from service.jobs.requested_options import RequestedOptions
from service.jobs.store_calls import call_store
from service.jobs.store_ports import BlobStore, FitStore

FIT_ID = re.compile("[0-9a-f]{32}")


class FitService:
    """The use cases of fits. The stores block, so they are called in threads, and the event loop never waits."""

    def __init__(  # noqa: PLR0913 - six ports, one setting
        self,
        store: FitStore,
        blobs: BlobStore,
        queue: FitQueue,
        reader: Reader,
        *,
        planner: Planner,
        callbacks: CallbackRules,
        split_points: int,
    ) -> None:
        """Use these ports; split fits of more than `split_points` points that can be made from moments."""
        self._store, self._blobs, self._queue = store, blobs, queue
        self._reader, self._planner = reader, planner
        self._callbacks, self._split_points = callbacks, split_points
        self._adding: set[asyncio.Task[Accepted]] = set()
        self._roomy = False  # whether there was much room in the queue at the last look

    async def check_room(self, caller: Caller, key: str | None = None, *, small: bool = False) -> None:
        """Refuse a fit before the body of its request is read.

        A small body is read at once while the queue is not even half full: accepting it checks the same.

        Raises
        ------
        NotReadyError, ShuttingDownError, QueueFullError, QuotaExceededError
            If a fit of this caller would not be accepted now; but not if one was accepted with the same key.

        """
        self._refuse_when_stopping()
        if small and self._roomy:
            return
        usage = await call_store(self._store.usage, caller)
        self._roomy = self._store.admission.has_much_room(usage)
        try:
            self._store.admission.check(usage, caller.quota)
        except (QueueFullError, QuotaExceededError):
            if key is None or not await call_store(self._store.has_key, caller.owner, key):
                raise

    async def read(self, body: bytes | Path, asked: ReadRequest) -> ReceivedPoints:
        """Read and check the body of a request; nothing is accepted yet."""
        return await self._reader.read(body, asked)

    def plan(self, points: ReceivedPoints, requested: RequestedOptions) -> ipcore.Plan:
        """Return what a fit will take; nothing is accepted yet.

        Raises
        ------
        InvalidInputError
            If the options are not allowed for points of this dimension.

        """
        return self._planner.plan(points, requested.complete)

    async def accept(  # noqa: PLR0913 - what is fitted, how, for whom
        self,
        points: ReceivedPoints,
        requested: RequestedOptions,
        plan: ipcore.Plan,
        caller: Caller,
        key: str | None = None,
        *,
        callback: str | None = None,
    ) -> Accepted:
        """Store a fit and queue it. When this returns, it survives a crash.

        Parameters
        ----------
        points, requested
            The point set and the options.
        plan
            What `plan` returned for them.
        caller
            Who sent it.
        key
            Idempotency key: a second call with the same key returns the fit of the first.
        callback
            URL that is told of the end of the fit.

        Raises
        ------
        InvalidInputError
            If nothing can or may be sent to the callback.
        NotReadyError, ShuttingDownError, QueueFullError, QuotaExceededError
            If it cannot be stored, the server is about to stop, or too many fits wait, of all callers or of this one.
        KeyReusedError
            If an earlier call with this key had another point set, other options or another callback.

        """
        self._refuse_when_stopping()
        if callback is not None:
            self._callbacks.check(callback)
        new, parts = new_fit(points, requested, plan, caller=caller, key=key, callback=callback), list[Fit]()
        if points.frame is not None and points.points > self._split_points and plan.summable:
            new, parts = split(new, points.frame, self._split_points)
        # To its end, even if the caller goes away meanwhile: a fit that is stored has to be queued as well.
        adding = asyncio.create_task(self._add_and_submit(new, points.content, parts, caller.quota))
        self._adding.add(adding)
        adding.add_done_callback(self._added)
        return await asyncio.shield(adding)

    async def _add_and_submit(self, new: Fit, content: bytes, parts: list[Fit], quota: Quota) -> Accepted:
        """Store a fit and queue it, unless it was stored before."""
        try:
            fit, usage = await self._add(new, content, parts, quota)
        except BaseException:
            self._roomy = False  # until room is seen again
            raise
        admission, replayed = self._store.admission, fit.id != new.id
        self._roomy, allowances = admission.has_much_room(usage), admission.allowances(usage, quota)
        if replayed:
            return Accepted(fit, allowances, replayed=True)
        for one in parts or [fit]:
            self._queue.submit(one)
        return Accepted(fit, [one.after_one() for one in allowances])

    def _added(self, adding: asyncio.Task[Accepted]) -> None:
        self._adding.discard(adding)
        if not adding.cancelled():
            adding.exception()  # nobody else may be left to look at it

    async def _add(self, new: Fit, content: bytes, parts: list[Fit], quota: Quota) -> tuple[Fit, Usage]:
        """Store a fit with its input; if that fails, remove the input, which may take the last room on the disk."""
        try:
            return await call_store(self._store.add, new, lambda: self._blobs.put(content, new.input.key), parts, quota)
        except NotReadyError:
            with suppress(Exception):
                await asyncio.to_thread(self._store.discard, new.input.key, self._blobs.delete)
            raise

    async def get(self, caller: Caller, fit_id: str, wait: float = 0.0) -> Fit:
        """Return a fit, after at most `wait` seconds if it is still live.

        Raises
        ------
        FitNotFoundError
            If there is none, or it belongs to another owner.
        NotReadyError
            If the store fails.

        """
        return await self.awaited(caller, await self._get(caller, fit_id), wait)

    async def awaited(self, caller: Caller, fit: Fit, wait: float) -> Fit:
        """Return a fit as it is when it has ended, or after at most `wait` seconds.

        Raises
        ------
        FitNotFoundError, NotReadyError
            As for `get`: it may be removed meanwhile.

        """
        if wait <= 0.0 or fit.status.final:
            return fit
        await self._queue.wait(fit.id, wait)
        return await self._get(caller, fit.id)

    async def progress(self, fit: Fit) -> list[dict[str, Any]]:
        """Return the degrees that a running fit has tried so far."""
        return [] if fit.status.final else await self._queue.progress(fit.id)

    async def check(self) -> None:
        """Check that the server is ready: fits can be looked up, and new ones are accepted.

        Raises
        ------
        NotReadyError, ShuttingDownError
            If the store fails, or the server is about to stop.

        """
        self._refuse_when_stopping()
        await call_store(self._store.count_waiting)

    async def listed(self, caller: Caller, page: Page) -> Sequence[Fit]:
        """Return the caller's fits of a page, without their results."""
        return await call_store(self._store.listed, page, caller.owner)

    async def dismiss(self, caller: Caller, fit_id: str) -> Fit:
        """Dismiss a fit if it is live, kill its worker, and return the fit."""
        await self._get(caller, fit_id)
        if await call_store(self._store.dismiss, fit_id):
            self._queue.cancel(fit_id)
        return await self._get(caller, fit_id)

    async def purge(self, caller: Caller, fit_id: str) -> None:
        """Remove a fit that has ended, with its points."""
        await self._get(caller, fit_id)
        await call_store(self._store.remove, fit_id, self._blobs.delete)

    async def drain(self, seconds: float) -> None:
        """Accept and start no more fits, give those that run so much time to end, then end every wait for a fit."""
        await self._queue.drain(seconds)

    def end_drain(self) -> None:
        """End a drain at once."""
        self._queue.end_drain()

    def _refuse_when_stopping(self) -> None:
        if self._queue.stopping:
            raise ShuttingDownError("the server is stopping; try again when it is back")

    async def _get(self, caller: Caller, fit_id: str) -> Fit:
        # no database is asked for what no fit can be called: PostgreSQL does not take a text with a zero byte
        fit = await call_store(self._store.get, fit_id) if FIT_ID.fullmatch(fit_id) else None
        if fit is None or fit.owner != caller.owner or fit.whole is not None:  # parts are internal
            raise FitNotFoundError(f"there is no fit {fit_id[:40]}")
        return fit
