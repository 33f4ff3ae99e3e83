"""The use cases: read, accept, look up, wait, draw, dismiss."""

import asyncio
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol
from uuid import uuid4

from service.jobs.drawing import Drawing
from service.jobs.errors import (
    FitNotFinishedError,
    FitNotFoundError,
    FitWithoutResultError,
    NotReadyError,
    ShuttingDownError,
)
from service.jobs.fit import Fit, FitStatus, PointSet, PointSetRef
from service.jobs.ports import BlobStore, FitQueue, FitStore


class Reader(Protocol):
    """Turns a body into a checked point set."""

    async def read(self, body: bytes | Path, kind: str) -> PointSet:
        """Read and check.

        Raises
        ------
        InvalidInputError
            If it cannot be fitted.

        """

    def check(self, dimension: int, options: dict[str, Any]) -> None:
        """Refuse options that cannot be meant, alone or together.

        Raises
        ------
        InvalidInputError
            If there are any; `at` names one.

        """


class Draughtsman(Protocol):
    """Draws zero sets."""

    async def draw(self, result: bytes, points: bytes, dimension: int, drawing: Drawing) -> bytes:
        """Return a file with the zero set of a fit's result, given its point set."""


class FitDesk:
    """What a caller can have done with fits. Blocking stores are called in threads, so the event loop never waits."""

    def __init__(
        self, store: FitStore, blobs: BlobStore, queue: FitQueue, reader: Reader, draughtsman: Draughtsman
    ) -> None:
        """Work with these parts."""
        self._store, self._blobs, self._queue = store, blobs, queue
        self._reader, self._draughtsman = reader, draughtsman
        self._tidy = asyncio.Lock()  # a blob must not be removed between its being found and its being used

    async def read(self, body: bytes | Path, kind: str) -> PointSet:
        """Read and check a body; nothing is accepted yet."""
        return await self._reader.read(body, kind)

    async def accept(self, points: PointSet, options: dict[str, Any]) -> Fit:
        """Store a fit and see that it is run. When this returns, it survives a crash.

        Raises
        ------
        InvalidInputError
            If the options cannot be meant.
        NotReadyError, ShuttingDownError
            If it cannot be stored, or the server is about to stop.

        """
        self._reader.check(points.dimension, options)
        self._refuse_when_stopping()
        try:
            async with self._tidy:
                fit = await asyncio.to_thread(self._add, points, options)
        except Exception as error:
            raise NotReadyError(f"the fit cannot be stored: {type(error).__name__}") from error
        self._queue.submit(fit.id)
        return fit

    async def get(self, fit_id: str, wait: float = 0.0) -> Fit:
        """Return a fit, after at most `wait` seconds if it is still live.

        Raises
        ------
        FitNotFoundError
            If there is none.

        """
        fit = await self._get(fit_id)
        if wait > 0.0 and not fit.status.final:
            await self._queue.wait(fit_id, wait)
            fit = await self._get(fit_id)
        return fit

    def progress(self, fit: Fit) -> list[dict[str, Any]]:
        """Return the degrees that a running fit has tried so far."""
        return self._queue.progress(fit.id)

    async def draw(self, fit_id: str, drawing: Drawing) -> bytes:
        """Return a file with the zero set of a successful fit.

        Raises
        ------
        FitNotFinishedError, FitWithoutResultError
            If there is nothing to draw, yet or for good.

        """
        fit = await self._get(fit_id)
        if not fit.status.final:
            raise FitNotFinishedError(f"fit {fit_id} is {fit.status}; its zero set can be drawn when it is successful")
        if fit.result is None:
            raise FitWithoutResultError(f"fit {fit_id} is {fit.status} and has no zero set")
        try:
            points = await asyncio.to_thread(self._blobs.get, fit.input.key)
        except FileNotFoundError:
            await self._get(fit_id)  # which says so, if the fit was removed in this very moment
            raise
        return await self._draughtsman.draw(fit.result, points, fit.input.dimension, drawing)

    async def check(self) -> None:
        """Return if fits can be stored and run.

        Raises
        ------
        NotReadyError, ShuttingDownError
            If the store fails, or the server is about to stop.

        """
        self._refuse_when_stopping()
        try:
            await asyncio.to_thread(self._store.waiting)
        except Exception as error:
            raise NotReadyError(f"fits cannot be stored: {type(error).__name__}") from error

    async def dismiss(self, fit_id: str) -> Fit | None:
        """Dismiss a live fit, killing its worker, and return it; or remove one that has ended, and return None."""
        fit = await self._get(fit_id)
        if await asyncio.to_thread(self._store.dismiss, fit_id):
            self._queue.cancel(fit_id)
            return await self._get(fit_id)
        async with self._tidy:
            await asyncio.to_thread(self._remove, fit)
        return None

    def stop(self) -> None:
        """Accept nothing more, and answer those who wait with what is known now."""
        self._queue.stop()

    def _refuse_when_stopping(self) -> None:
        if self._queue.stopping:
            raise ShuttingDownError("the server is stopping; try again when it is back")

    def _add(self, points: PointSet, options: dict[str, Any]) -> Fit:
        fit = Fit(
            id=uuid4().hex,
            status=FitStatus.ACCEPTED,
            input=PointSetRef(self._blobs.put(points.content), points.dimension, points.points),
            options=options,
            created=datetime.now(UTC),
        )
        self._store.add(fit)
        return fit

    def _remove(self, fit: Fit) -> None:
        self._store.remove(fit.id)
        if not self._store.uses(fit.input.key):
            self._blobs.delete(fit.input.key)

    async def _get(self, fit_id: str) -> Fit:
        fit = await asyncio.to_thread(self._store.get, fit_id)
        if fit is None:
            raise FitNotFoundError(f"there is no fit {fit_id[:40]}")
        return fit
