"""The embedded queue: fits of one server, run by its own pool."""

import asyncio
import logging
from contextlib import suppress
from typing import Any

from service.jobs.fit import Fit
from service.jobs.ports import FitStore
from service.queue.fair_queue import FairQueue
from service.queue.runner import Runner, pause

logger = logging.getLogger(__name__)


class EmbeddedQueue:
    """Runs fits in so many seats, some of them for short fits only."""

    def __init__(self, store: FitStore, runner: Runner, *, seats: int, short_seats: int) -> None:
        """Run at most `seats` fits of any length at once, and `short_seats` more that are short."""
        self._store, self._runner = store, runner
        self._lanes = [False] * seats + [True] * short_seats
        self._line = FairQueue()
        self._live: dict[str, Fit] = {}
        self._running: dict[str, asyncio.Task[None]] = {}
        self._ended: dict[str, asyncio.Event] = {}
        self._split: set[str] = set()  # fits that are not in line themselves yet, but their parts
        self._tries: dict[str, int] = {}
        self._seats: list[asyncio.Task[None]] = []
        self._late: asyncio.Task[None] | None = None
        self._news = asyncio.Event()
        self._draining = False
        self._begun, self._hurried, self._stopped = asyncio.Event(), asyncio.Event(), asyncio.Event()

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop, and nothing new is to be accepted."""
        return self._draining

    def submit(self, fit: Fit) -> None:
        """Put an accepted fit, or a part of one, in line, once."""
        if fit.id in self._live:
            return
        if fit.whole is not None:
            self._split.add(fit.whole)
        self._live[fit.id] = fit
        self._ended.setdefault(fit.whole or fit.id, asyncio.Event())  # of a fit in parts, from the first part on
        self._line.join(fit)
        self._news.set()

    def cancel(self, fit_id: str) -> None:
        """Kill the workers that run the fit and its parts, or take them out of the line."""
        for one in [fit_id, *(part.id for part in self._live.values() if part.whole == fit_id)]:
            self._cancel(one)
        if fit_id in self._split:
            self._forget(fit_id)

    def _cancel(self, fit_id: str) -> None:
        if fit_id in self._running:
            self._running[fit_id].cancel()
        elif fit_id in self._live:
            self._line.leave(self._live[fit_id])
            self._forget(fit_id)

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._happens(self._begun)
                if (ended := self._ended.get(fit_id)) is not None:
                    await self._happens(ended)

    async def _happens(self, event: asyncio.Event) -> None:
        """Return when this has happened, or the server is about to stop."""
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
        """Start, with everything that was accepted or running when the server last stopped.

        If the store fails, the disk being full, the server answers meanwhile, and this goes on when it can.
        """
        if not await self._resumed():
            self._late = asyncio.create_task(self._resume_later())

    async def _resume_later(self) -> None:
        tries = 0
        while not await self._resumed():
            tries += 1
            await asyncio.sleep(pause(tries))

    async def _resumed(self) -> bool:
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
        self._seats = [asyncio.create_task(self._seat(short=short)) for short in self._lanes]
        self._begun.set()
        return True

    async def drain(self, seconds: float) -> None:
        """Start nothing more, give what runs so much time to end, then let everybody who waits for a fit go."""
        self._draining = True
        self._news.set()
        if self._running:
            hurried = asyncio.create_task(self._hurried.wait())
            running = asyncio.gather(*self._running.values(), return_exceptions=True)
            await asyncio.wait((running, hurried), timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
            hurried.cancel()
        self._stopped.set()

    def hurry(self) -> None:
        """End a drain at once."""
        self._hurried.set()

    async def close(self) -> None:
        """Kill what runs; it stays accepted in the store, for the next start."""
        tasks = [*self._seats, *self._running.values(), *([self._late] if self._late else [])]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _seat(self, *, short: bool) -> None:
        """Run one fit after the other."""
        while (fit_id := await self._next(short=short)) is not None:
            run = asyncio.create_task(self._runner.run(fit_id), name=f"fit {fit_id}")
            self._running[fit_id] = run
            try:
                await asyncio.wait((run,))  # not `await run`: that a fit is cancelled is no reason to leave the seat
            finally:
                del self._running[fit_id]
            if run.cancelled() or (run.exception() is None and await self._over(fit_id)):
                self._forget(fit_id)
            else:
                self._put_back(fit_id, run.exception())

    async def _over(self, fit_id: str) -> bool:
        """Return whether a fit has ended: one that was given up for any other reason must not be forgotten."""
        part = self._live.get(fit_id)
        with suppress(Exception):
            fit = await asyncio.to_thread(self._store.get, fit_id)
            if fit is not None and not fit.status.final:
                return False
            if part is not None and part.whole is not None:
                await self._go_on(part.whole)
            return True
        return False

    async def _go_on(self, whole: str) -> None:
        """After the end of a part, put its fit in line if it was the last one, or end the others if the fit failed."""
        fit = await asyncio.to_thread(self._store.get, whole)
        if fit is None or fit.status.final:
            self.cancel(whole)
        elif fit.unsummed == 0 and whole in self._split:  # two parts may have ended together
            self._split.discard(whole)
            self.submit(fit)

    def _put_back(self, fit_id: str, error: BaseException | None) -> None:
        """Put a fit in line again, after a while: what went wrong may take its time to pass."""
        self._tries[fit_id] = self._tries.get(fit_id, 0) + 1
        seconds = pause(self._tries[fit_id])
        logger.warning("fit %s is put back in line in %g s", fit_id, seconds, exc_info=error)
        asyncio.get_running_loop().call_later(seconds, self._rejoin, fit_id)

    def _rejoin(self, fit_id: str) -> None:
        if fit_id in self._live:  # else it was dismissed meanwhile
            self._line.join(self._live[fit_id])
            self._news.set()

    async def _next(self, *, short: bool) -> str | None:
        """Return the next fit, when there is one; None when the server is about to stop."""
        while not self._draining:
            if (found := self._line.take(short=short)) is not None:
                return found
            self._news.clear()
            await self._news.wait()
        return None

    def _forget(self, fit_id: str) -> None:
        self._live.pop(fit_id, None)
        self._tries.pop(fit_id, None)
        self._split.discard(fit_id)
        ended = self._ended.pop(fit_id, None)
        if ended is not None:
            ended.set()
