"""The embedded queue: fits of one server, run by its own pool, first come, first served."""

import asyncio
import logging
from collections.abc import Callable
from typing import Any, TypeVar

from service.jobs.errors import DeadlineExceededError, WorkerCrashedError
from service.jobs.fit import Failure, Fit, FitStatus
from service.jobs.ports import BlobStore, FitStore, Workers

logger = logging.getLogger(__name__)

# A fit whose worker died is started once more; what kills two workers would kill a third.
MAX_ATTEMPTS = 2
# Seconds between tries when the store fails: an hour in all.
PAUSES = (1.0, 4.0, 15.0, *[60.0] * 60)

T = TypeVar("T")


class LocalQueue:
    """Runs each submitted fit as soon as a worker is free."""

    def __init__(  # noqa: PLR0913 - four parts, two numbers
        self,
        store: FitStore,
        blobs: BlobStore,
        workers: Workers,
        task: Callable[..., bytes],
        *,
        slots: int,
        deadline: float,
    ) -> None:
        """Run at most `slots` fits at once, each at most `deadline` seconds, by calling `task` in a worker."""
        self._store, self._blobs, self._workers, self._task = store, blobs, workers, task
        self._slots = asyncio.Semaphore(slots)
        self._deadline = deadline
        self._running: dict[str, asyncio.Task[None]] = {}
        self._steps: dict[str, list[dict[str, Any]]] = {}
        self._stopping = asyncio.Event()

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop, and nothing new is to be accepted."""
        return self._stopping.is_set()

    def submit(self, fit_id: str) -> None:
        """See that an accepted fit is run."""
        task = asyncio.create_task(self._serve(fit_id), name=f"fit {fit_id}")
        self._running[fit_id] = task
        task.add_done_callback(lambda _: self._running.pop(fit_id, None))

    def cancel(self, fit_id: str) -> None:
        """Kill the worker that runs the fit, or take it out of the line."""
        task = self._running.get(fit_id)
        if task is not None:
            task.cancel()

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""
        task = self._running.get(fit_id)
        if task is None:
            return
        stopping = asyncio.create_task(self._stopping.wait())
        try:
            await asyncio.wait((task, stopping), timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
        finally:
            stopping.cancel()

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a running fit."""
        return list(self._steps.get(fit_id, ()))

    async def resume(self) -> None:
        """Submit everything that was accepted or running when the server last stopped."""
        recovered = await asyncio.to_thread(self._store.recover)
        waiting = await asyncio.to_thread(self._store.waiting)
        if waiting:
            logger.info("resuming %d fits, %d of them interrupted", len(waiting), recovered)
        for fit_id in waiting:
            self.submit(fit_id)

    def stop(self) -> None:
        """Let everybody who waits for a fit go: the server is about to stop."""
        self._stopping.set()

    async def close(self) -> None:
        """Kill what runs; it stays accepted in the store, for the next start."""
        tasks = list(self._running.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _serve(self, fit_id: str) -> None:
        """Run one fit to its end, again if its worker dies."""
        async with self._slots:
            while (attempt := await self._insist(self._store.start, fit_id)) is not None:
                try:
                    await self._attempt(fit_id, attempt)
                except asyncio.CancelledError:
                    await asyncio.shield(asyncio.to_thread(self._store.release, fit_id, attempt))
                    raise
                finally:
                    self._steps.pop(fit_id, None)

    async def _attempt(self, fit_id: str, attempt: int) -> None:
        """Run one attempt and store how it ended."""
        fit = await self._insist(self._store.get, fit_id)
        if fit is None:
            return
        try:
            result = await self._run(fit)
        except WorkerCrashedError as error:
            logger.warning("fit %s, attempt %d: %s", fit_id, attempt, error)
            if attempt < MAX_ATTEMPTS:
                await self._insist(self._store.release, fit_id, attempt)
                return
            failure = Failure("worker-crashed", f"The worker process died in each of {attempt} attempts.")
        except DeadlineExceededError:
            failure = Failure("deadline-exceeded", f"The fit took longer than {self._deadline:g} s and was stopped.")
        except Exception as error:
            logger.exception("fit %s failed", fit_id)
            failure = Failure("fit-error", f"{type(error).__name__}: {error}")
        else:
            await self._insist(self._store.finish, fit_id, attempt, FitStatus.SUCCESSFUL, result, None)
            return
        await self._insist(self._store.finish, fit_id, attempt, FitStatus.FAILED, None, failure)

    async def _insist(self, call: Callable[..., T], *arguments: object) -> T:
        """Call the store, again and again while it fails: a full disk must not lose a fit or what was worked out."""
        for pause in PAUSES:
            try:
                return await asyncio.to_thread(call, *arguments)
            except Exception:
                logger.exception("the store failed; the next try is in %g s", pause)
                await asyncio.sleep(pause)
        return await asyncio.to_thread(call, *arguments)

    async def _run(self, fit: Fit) -> bytes:
        steps = self._steps.setdefault(fit.id, [])
        result: bytes = await self._workers.run(
            self._task,
            self._blobs,
            fit.input.key,
            fit.input.dimension,
            fit.options,
            deadline=self._deadline,
            progress=steps.append,
        )
        return result
