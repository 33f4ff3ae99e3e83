"""One fit at a time, from its lease to its end, whatever happens on the way."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from service.jobs.errors import DeadlineExceededError, NotReadyError, OutOfMemoryError, WorkerCrashedError
from service.jobs.fit import MAX_CRASHES, Failure, Fit, FitStatus, Holder
from service.jobs.ports import BlobStore, FitStore, Workers

logger = logging.getLogger(__name__)

# Seconds between tries when the store fails: an hour in all.
PAUSES = (1.0, 4.0, 15.0, *[60.0] * 60)
# A fit whose points cannot be read is put back in line so often, each time for longer: for an hour in all, too.
MAX_AWAY = 91
# Seconds that giving a fit back may take when this process is about to end; the lease gives it back anyway.
PARTING = 2.0
# Seconds between two looks of the keeper of a lease, which also passes progress on.
TICK = 0.5

T = TypeVar("T")


def pause(tries: int) -> float:
    """Return the seconds after which a fit that was put back is tried again.

    >>> pause(1), sum(pause(tries) for tries in range(1, MAX_AWAY)) / 3600.0 > 1.0
    (1.0, True)
    """
    return min(float(tries), 60.0)


@dataclass(frozen=True)
class Tasks:
    """What workers are given to do. Each takes the blobs, the fit's `PointSetRef` and its `ipcore.FitOptions`.

    Attributes
    ----------
    fit
        A fit as a whole.
    part
        The moments of some of the points; takes their `Slice`, too.
    rest
        What is left of a fit whose parts have ended; takes what they resulted in.

    """

    fit: Callable[..., bytes]
    part: Callable[..., bytes]
    rest: Callable[..., bytes]


class Runner:
    """Runs fits that the store gives it on a lease, which it renews from here: a process inside LAPACK could not."""

    def __init__(  # noqa: PLR0913 - four parts, three facts
        self,
        store: FitStore,
        blobs: BlobStore,
        workers: Workers,
        tasks: Tasks,
        *,
        holder: Holder,
        deadline: float,
        publish: bool = False,
    ) -> None:
        """Run each fit, or part of one, at most `deadline` seconds in a worker; `publish` progress in the store."""
        self._store, self._blobs, self._workers, self._tasks = store, blobs, workers, tasks
        self._holder, self._deadline, self._publish = holder, deadline, publish
        self._steps: dict[str, list[dict[str, Any]]] = {}

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a fit that runs here."""
        return list(self._steps.get(fit_id, ()))

    async def run(self, fit_id: str) -> None:
        """Run one fit to its end, again if its worker dies; cancelled, kill its worker and give it back.

        Raises
        ------
        NotReadyError
            If what it needs is away. It was given back, to be run after `pause` seconds, here or elsewhere.

        """
        while (attempt := await self._insist(self._store.start, fit_id, self._holder)) is not None:
            try:
                await self._attempt(fit_id, attempt)
            except asyncio.CancelledError:
                await asyncio.shield(self._give_back(fit_id, attempt))
                raise
            finally:
                self._steps.pop(fit_id, None)

    async def _attempt(self, fit_id: str, attempt: int) -> None:
        """Run one attempt and store how it ended."""
        fit = await self._insist(self._store.get, fit_id)
        if fit is None:
            return
        try:
            result = await self._while_held(fit, attempt)
        except WorkerCrashedError as error:
            logger.warning("fit %s, attempt %d: %s", fit_id, attempt, error)
            if fit.crashes + 1 < MAX_CRASHES:
                await self._insist(lambda: self._store.release(fit_id, attempt, crashed=True))
                return
            failure = Failure("worker-crashed", f"The worker process died {MAX_CRASHES} times.")
        except NotReadyError as error:
            logger.warning("fit %s, attempt %d: %s", fit_id, attempt, error)
            if attempt < MAX_AWAY:
                await self._insist(self._store.release, fit_id, attempt)
                raise
            failure = Failure("fit-error", f"Given up after {MAX_AWAY} tries: {error}")
        except (DeadlineExceededError, OutOfMemoryError) as error:
            failure = self._limit(error)
        except Exception as error:
            logger.exception("fit %s failed", fit_id)
            failure = Failure("fit-error", f"{type(error).__name__}: {error}")
        else:
            if result is not None:
                await self._insist(self._store.finish, fit_id, attempt, FitStatus.SUCCESSFUL, result, None)
            return
        await self._insist(self._store.finish, fit_id, attempt, FitStatus.FAILED, None, failure)

    def _limit(self, error: DeadlineExceededError | OutOfMemoryError) -> Failure:
        if isinstance(error, DeadlineExceededError):
            return Failure("deadline-exceeded", f"The fit took longer than {self._deadline:g} s and was stopped.")
        return Failure("out-of-memory", str(error))

    async def _while_held(self, fit: Fit, attempt: int) -> bytes | None:
        """Return the answer; or None, with the worker killed, as soon as this attempt holds the fit no more."""
        steps = self._steps.setdefault(fit.id, [])
        work = asyncio.create_task(self._in_worker(fit, steps))
        keeper = asyncio.create_task(self._keep(fit.id, attempt, steps))
        try:
            await asyncio.wait((work, keeper), return_when=asyncio.FIRST_COMPLETED)
            return work.result() if work.done() else None
        finally:
            for task in (keeper, work):
                task.cancel()
            await asyncio.gather(keeper, work, return_exceptions=True)

    async def _keep(self, fit_id: str, attempt: int, steps: list[dict[str, Any]]) -> None:
        """Renew the lease at each third of it, and pass progress on; return when the lease is lost.

        While the store fails the fit goes on: if the lease runs out meanwhile, and another takes the fit over, what is
        worked out here does not count.
        """
        clock = asyncio.get_running_loop().time
        renewal, told = clock() + self._holder.lease / 3.0, 0
        while True:
            await asyncio.sleep(TICK)
            held = True
            with suppress(Exception):
                if self._publish and len(steps) > told:
                    told = len(steps)
                    held = await asyncio.to_thread(self._store.report, fit_id, attempt, list(steps))
                if held and clock() >= renewal:
                    held = await asyncio.to_thread(self._store.renew, fit_id, attempt, self._holder.lease)
                    renewal = clock() + self._holder.lease / 3.0
            if not held:
                return

    async def _in_worker(self, fit: Fit, steps: list[dict[str, Any]]) -> bytes:
        arguments: list[Any] = [self._blobs, fit.input, fit.requested.complete]
        task = self._tasks.fit
        if fit.slice is not None:
            task = self._tasks.part
            arguments.append(fit.slice)
        elif fit.parts:
            task = self._tasks.rest
            arguments.append(await self._insist(self._store.sums, fit.id))
        result: bytes = await self._workers.run(task, *arguments, deadline=self._deadline, progress=steps.append)
        return result

    async def _give_back(self, fit_id: str, attempt: int) -> None:
        """Release a fit, with one try: the process is about to end, and the lease will be."""
        with suppress(Exception):
            await asyncio.wait_for(asyncio.to_thread(self._store.release, fit_id, attempt), PARTING)

    async def _insist(self, call: Callable[..., T], *arguments: object) -> T:
        """Call the store, again and again while it fails: a full disk must not lose a fit or what was worked out."""
        for pause in PAUSES:
            try:
                return await asyncio.to_thread(call, *arguments)
            except Exception:
                logger.exception("the store failed; the next try is in %g s", pause)
                await asyncio.sleep(pause)
        return await asyncio.to_thread(call, *arguments)
