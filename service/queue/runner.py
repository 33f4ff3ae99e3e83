"""Running one fit: from taking its lease to storing its result, through crashes and failures of the store."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

from service.jobs.errors import DeadlineExceededError, NotReadyError, OutOfMemoryError, WorkerCrashedError
from service.jobs.fit import MAX_CRASHES, Failure, Fit, FitStatus
from service.jobs.lease_holder import LeaseHolder
from service.jobs.observer import UNOBSERVED, FitObserver
from service.jobs.ports import Workers
from service.jobs.store_ports import BlobStore, FitStore
from service.queue.work import Lanes, Tasks, Work

logger = logging.getLogger(__name__)

# Seconds between tries when the store fails: an hour in all.
STORE_PAUSES = (1.0, 4.0, 15.0, *[60.0] * 60)
# How often a fit is queued again whose points cannot be read, after longer and longer pauses: an hour in all, too.
MAX_AWAY = 91
# Seconds that releasing a fit may take when this process is about to end; its lease runs out in any case.
RELEASE_SECONDS = 2.0
# Seconds after which a start is stored whose worker begins at once. If both were done at the same time, their threads
# would wait for each other in the interpreter.
HEAD_START = 0.003
# Seconds between two rounds of the task that renews a lease and reports progress.
LEASE_CHECK_SECONDS = 0.5

T = TypeVar("T")


def pause(tries: int) -> float:
    """Return the seconds to wait before the next try of a fit that failed `tries` times to start.

    >>> pause(1), sum(pause(tries) for tries in range(1, MAX_AWAY)) / 3600.0 > 1.0
    (1.0, True)
    """
    return min(float(tries), 60.0)


class Runner:
    """Runs fits in worker processes, each on a lease of the store.

    The lease is renewed here, in the supervising process: a worker inside a LAPACK call could not do it.
    """

    def __init__(  # noqa: PLR0913 - ports and settings
        self,
        store: FitStore,
        blobs: BlobStore,
        lanes: Lanes,
        tasks: Tasks,
        *,
        holder: LeaseHolder,
        deadline: float,
        publish: bool = False,
        observer: FitObserver = UNOBSERVED,
    ) -> None:
        """Give each fit or part at most `deadline` seconds in a worker; with `publish`, store its progress."""
        self._store, self._blobs, self._lanes, self._tasks = store, blobs, lanes, tasks
        self._observer = observer
        self._holder, self._deadline, self._publish = holder, deadline, publish
        self._steps: dict[str, list[dict[str, Any]]] = {}

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a fit that runs here."""
        return list(self._steps.get(fit_id, ()))

    async def run(self, fit_id: str, *, short: bool, known: Fit | None = None) -> bool:
        """Run one fit to its end, again if its worker dies. When cancelled, kill its worker and release the fit.

        It takes a worker of the lane of short fits, or of the lane of all. Return whether the fit has ended here. If
        not, it may have been dismissed, or another process may hold it.

        Parameters
        ----------
        fit_id, short
            Which fit, and whether in the lane of short fits.
        known
            The fit as it waits, if it is no part and has none: its worker then begins while the start is being stored.
            That takes some milliseconds, as long as a small fit.

        Raises
        ------
        NotReadyError
            If its points cannot be read. It was released, to be run again after `pause` seconds by any process.

        """
        workers = self._lanes.short if short else self._lanes.any_length
        work = None if known is None else self._begun(known, workers)
        try:
            if work is not None:
                await asyncio.wait((work.task,), timeout=HEAD_START)
            while (fit := await self._retried(self._store.start, fit_id, self._holder)) is not None:
                if await self._attempt(fit, work or self._begun(fit, workers)):
                    return True
                work = None
        finally:
            self._steps.pop(fit_id, None)
            if work is not None:
                await work.cancelled()
        return False

    async def _attempt(self, fit: Fit, work: Work) -> bool:
        """Run one attempt and store how it ended; return whether the fit has ended with it."""
        self._observer.started(fit)
        try:
            return await self._outcome(fit, work)
        except asyncio.CancelledError:
            await asyncio.shield(self._release(fit))
            raise
        finally:
            self._steps.pop(fit.id, None)

    async def _outcome(self, fit: Fit, work: Work) -> bool:
        """Wait for the work on a fit, and store how it ended; return whether the fit has ended with it."""
        try:
            result = await self._while_held(fit, work)
        except WorkerCrashedError as error:
            logger.warning("fit %s, attempt %d: %s", fit.id, fit.attempt, error)
            if fit.crashes + 1 < MAX_CRASHES:
                await self._retried(lambda: self._store.release(fit.id, fit.attempt, crashed=True))
                return False
            failure = Failure("worker-crashed", f"The worker process died {MAX_CRASHES} times.")
        except NotReadyError as error:
            logger.warning("fit %s, attempt %d: %s", fit.id, fit.attempt, error)
            if fit.attempt < MAX_AWAY:
                await self._retried(self._store.release, fit.id, fit.attempt)
                raise
            failure = Failure("fit-error", f"Given up after {MAX_AWAY} tries: {error}")
        except (DeadlineExceededError, OutOfMemoryError) as error:
            failure = self._limit(error)
        except Exception as error:
            logger.exception("fit %s failed", fit.id)
            failure = Failure("fit-error", f"{type(error).__name__}: {error}")
        else:
            return result is not None and await self._ended(fit, work, FitStatus.SUCCESSFUL, result)
        return await self._ended(fit, work, FitStatus.FAILED, None, failure)

    async def _ended(
        self, fit: Fit, work: Work, status: FitStatus, result: bytes | None, failure: Failure | None = None
    ) -> bool:
        """Store the end of a fit; return False if this attempt did not hold it any more."""
        stored = await self._retried(self._store.finish, fit.id, fit.attempt, status, result, failure)
        if stored:
            self._observer.ended(fit, status, result, work.seconds)
        return stored

    def _limit(self, error: DeadlineExceededError | OutOfMemoryError) -> Failure:
        """Return the failure of a fit that was over a limit."""
        if isinstance(error, DeadlineExceededError):
            return Failure("deadline-exceeded", f"The fit took longer than {self._deadline:g} s and was stopped.")
        return Failure("out-of-memory", str(error))

    def _begun(self, fit: Fit, workers: Workers) -> Work:
        """Begin the work on a fit."""
        return Work(self._in_worker(fit, self._steps.setdefault(fit.id, []), workers))

    async def _while_held(self, fit: Fit, work: Work) -> bytes | None:
        """Return the result; or kill the worker and return None as soon as this attempt does not hold the fit."""
        keeper = asyncio.create_task(self._keep_lease(fit.id, fit.attempt, self._steps.setdefault(fit.id, [])))
        try:
            await asyncio.wait((work.task, keeper), return_when=asyncio.FIRST_COMPLETED)
            return work.task.result() if work.task.done() else None
        finally:
            keeper.cancel()
            await work.cancelled()
            await asyncio.gather(keeper, return_exceptions=True)

    async def _keep_lease(self, fit_id: str, attempt: int, steps: list[dict[str, Any]]) -> None:
        """Renew the lease after each third of it, and report progress; return when the lease is lost.

        While the store fails, the fit goes on. If the lease runs out meanwhile and another process takes the fit, the
        store will not accept the result of this attempt.
        """
        clock = asyncio.get_running_loop().time
        renewal, reported = clock() + self._holder.lease / 3.0, 0
        while True:
            await asyncio.sleep(LEASE_CHECK_SECONDS)
            held = True
            with suppress(Exception):
                if self._publish and len(steps) > reported:
                    reported = len(steps)
                    held = await asyncio.to_thread(self._store.report, fit_id, attempt, list(steps))
                if held and clock() >= renewal:
                    held = await asyncio.to_thread(self._store.renew, fit_id, attempt, self._holder.lease)
                    renewal = clock() + self._holder.lease / 3.0
            if not held:
                return

    async def _in_worker(self, fit: Fit, steps: list[dict[str, Any]], workers: Workers) -> bytes:
        """Run the task of a fit, or of a part, in a worker; append the degrees that it reports to `steps`."""
        arguments: list[Any] = [self._blobs, fit.input, fit.requested.complete]
        task = self._tasks.fit
        if fit.slice is not None:
            task = self._tasks.sum_moments
            arguments.append(fit.slice)
        elif fit.parts:
            task = self._tasks.fit_from_moments
            arguments.append(await self._retried(self._store.sums, fit.id))
        result: bytes = await workers.run(task, *arguments, deadline=self._deadline, progress=steps.append)
        return result

    async def _release(self, fit: Fit) -> None:
        """Release a fit, with a single try: this process is about to end, and the lease runs out in any case."""
        with suppress(Exception):
            await asyncio.wait_for(asyncio.to_thread(self._store.release, fit.id, fit.attempt), RELEASE_SECONDS)

    async def _retried(self, call: Callable[..., T], *arguments: object) -> T:
        """Call the store until it succeeds, for an hour: a full disk must not lose a fit or its result."""
        for pause in STORE_PAUSES:
            try:
                return await asyncio.to_thread(call, *arguments)
            except Exception:
                logger.exception("the store failed; the next try is in %g s", pause)
                await asyncio.sleep(pause)
        return await asyncio.to_thread(call, *arguments)
