"""The embedded queue: the fits of one server, run by its own worker pool."""

import asyncio
import logging
from contextlib import suppress
from typing import Any

from service.jobs.fit import Fit
from service.jobs.store_ports import FitStore
from service.queue.fair_queue import FairQueue
from service.queue.runner import Runner, pause

logger = logging.getLogger(__name__)


class EmbeddedQueue:
    """Runs a fixed number of fits at once; some of its seats take short fits only."""

    def __init__(self, store: FitStore, runner: Runner, *, seats: int, short_seats: int) -> None:
        """Run at most `seats` fits of any length at once, and `short_seats` more that are short."""
        self._store, self._runner = store, runner
        self._short_only = [False] * seats + [True] * short_seats
        self._queue = FairQueue()
        self._live: dict[str, Fit] = {}  # fits and parts that were submitted and have not ended
        self._running: dict[str, asyncio.Task[bool]] = {}
        self._ended: dict[str, asyncio.Event] = {}  # set when a fit has ended, with its parts
        self._split: set[str] = set()  # fits whose parts are still to be summed; they are not in the queue themselves
        self._tries: dict[str, int] = {}
        self._seats: list[asyncio.Task[None]] = []
        self._late_start: asyncio.Task[None] | None = None
        self._changed = asyncio.Event()
        self._draining = False
        self._started, self._drain_ended, self._stopped = asyncio.Event(), asyncio.Event(), asyncio.Event()

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop; nothing new is to be accepted then."""
        return self._draining

    def submit(self, fit: Fit) -> None:
        """Add an accepted fit, or a part of one, to the queue; do nothing if it was submitted before."""
        if fit.id in self._live:
            return
        if fit.whole is not None:
            self._split.add(fit.whole)
        self._live[fit.id] = fit
        self._ended.setdefault(fit.whole or fit.id, asyncio.Event())  # for a fit in parts, with its first part
        self._queue.add(fit)
        self._changed.set()

    def cancel(self, fit_id: str) -> None:
        """Kill the workers that run the fit and its parts, or remove them from the queue."""
        for one in [fit_id, *(part.id for part in self._live.values() if part.whole == fit_id)]:
            self._cancel(one)
        if fit_id in self._split:
            self._forget(fit_id)

    def _cancel(self, fit_id: str) -> None:
        if fit_id in self._running:
            self._running[fit_id].cancel()
        elif fit_id in self._live:
            self._queue.remove(self._live[fit_id])
            self._forget(fit_id)

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._set_or_stopped(self._started)
                if (ended := self._ended.get(fit_id)) is not None:
                    await self._set_or_stopped(ended)

    async def _set_or_stopped(self, event: asyncio.Event) -> None:
        """Return when the event is set, or the server is about to stop."""
        waits = [asyncio.create_task(one.wait()) for one in (event, self._stopped)]
        try:
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in waits:
                task.cancel()

    async def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a running fit."""
        return self._runner.progress(fit_id)

    async def resume(self) -> None:
        """Start with all fits that were accepted or running when the server last stopped.

        If the store fails, for example because the disk is full, the server answers requests, and this is tried again.
        """
        if not await self._resumed():
            self._late_start = asyncio.create_task(self._resume_later())

    async def _resume_later(self) -> None:
        tries = 0
        while not await self._resumed():
            tries += 1
            await asyncio.sleep(pause(tries))

    async def _resumed(self) -> bool:
        """Submit the stored fits and start the seats; return False if the store fails."""
        try:
            recovered = await asyncio.to_thread(self._store.recover)
            waiting = await asyncio.to_thread(self._store.waiting)
        except Exception:
            logger.exception("the store failed: no fit is run yet")
            return False
        if waiting:
            logger.info("resuming %d fits, %d of them interrupted", len(waiting), recovered)
        for fit in waiting:
            self.submit(fit)
        self._seats = [asyncio.create_task(self._run_seat(short=short)) for short in self._short_only]
        self._started.set()
        return True

    async def drain(self, seconds: float) -> None:
        """Start no more fits, give those that run so much time to end, then end every `wait`."""
        self._draining = True
        self._changed.set()
        if self._running:
            end = asyncio.create_task(self._drain_ended.wait())
            running = asyncio.gather(*self._running.values(), return_exceptions=True)
            await asyncio.wait((running, end), timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
            end.cancel()
        self._stopped.set()

    def end_drain(self) -> None:
        """End a drain at once."""
        self._drain_ended.set()

    async def close(self) -> None:
        """Kill the workers of running fits, which stay accepted in the store until the next start."""
        tasks = [*self._seats, *self._running.values(), *([self._late_start] if self._late_start else [])]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _run_seat(self, *, short: bool) -> None:
        """Run one fit after another."""
        while (fit_id := await self._next(short=short)) is not None:
            fit = self._live[fit_id]
            known = None if fit.parts or fit.whole else fit
            run = asyncio.create_task(self._runner.run(fit_id, short=short, known=known), name=f"fit {fit_id}")
            self._running[fit_id] = run
            try:
                await asyncio.wait((run,))  # not `await run`: a fit that is cancelled must not end the seat
            finally:
                del self._running[fit_id]
                self._queue.ended(fit_id)
                self._changed.set()  # the lane of short fits may now be open to the same client
            if run.cancelled() or (run.exception() is None and await self._has_ended(fit_id, stored=run.result())):
                self._forget(fit_id)
            else:
                self._requeue_later(fit_id, run.exception())

    async def _has_ended(self, fit_id: str, *, stored: bool) -> bool:
        """Return whether a fit has ended in the store. If not, or if the store fails, it has to run again.

        With `stored`, it has ended for certain, but what follows from the end of a part may fail.
        """
        part = self._live.get(fit_id)
        with suppress(Exception):
            fit = None if stored else await asyncio.to_thread(self._store.get, fit_id)
            if fit is not None and not fit.status.final:
                return False
            if part is not None and part.whole is not None:
                await self._continue_whole(part.whole)
            return True
        return False

    async def _continue_whole(self, whole: str) -> None:
        """After the end of a part, submit its fit if that was the last part, or cancel the others if the fit failed."""
        fit = await asyncio.to_thread(self._store.get, whole)
        if fit is None or fit.status.final:
            self.cancel(whole)
        elif fit.unsummed == 0 and whole in self._split:  # two parts may have ended together
            self._split.discard(whole)
            self.submit(fit)

    def _requeue_later(self, fit_id: str, error: BaseException | None) -> None:
        """Add a fit to the queue again after some seconds, in which the cause of its failure may pass."""
        self._tries[fit_id] = self._tries.get(fit_id, 0) + 1
        seconds = pause(self._tries[fit_id])
        logger.warning("fit %s is queued again in %g s", fit_id, seconds, exc_info=error)
        asyncio.get_running_loop().call_later(seconds, self._requeue, fit_id)

    def _requeue(self, fit_id: str) -> None:
        if fit_id in self._live:  # else it was dismissed meanwhile
            self._queue.add(self._live[fit_id])
            self._changed.set()

    async def _next(self, *, short: bool) -> str | None:
        """Return the next fit, when there is one; None when the server is about to stop."""
        while not self._draining:
            if (found := self._queue.take(short=short)) is not None:
                return found
            self._changed.clear()
            await self._changed.wait()
        return None

    def _forget(self, fit_id: str) -> None:
        self._live.pop(fit_id, None)
        self._tries.pop(fit_id, None)
        self._split.discard(fit_id)
        ended = self._ended.pop(fit_id, None)
        if ended is not None:
            ended.set()
