"""The queue as a stateless API process sees it: others run the fits, and PostgreSQL tells when one has ended."""

import asyncio
import logging
from contextlib import suppress
from typing import Any

import psycopg

from service.jobs.fit import Fit
from service.jobs.ports import FitStore
from service.queue.procrastinate_jobs import ENDED

logger = logging.getLogger(__name__)

# Seconds between two looks for those who wait, in case that a word was lost with the connection it came on.
LOOK = 2.0
# Seconds before a broken connection is made anew.
PAUSE = 1.0


class FitListener:
    """Waits for fits that were put in line when they were stored."""

    def __init__(self, store: FitStore, url: str) -> None:
        """Listen at the database at `url`."""
        self._store, self._url = store, url
        self._waiting: dict[str, set[asyncio.Event]] = {}
        self._stopped = asyncio.Event()

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop, and nothing new is to be accepted."""
        return self._stopped.is_set()

    def submit(self, fit: Fit) -> None:
        """Do nothing: the fit joined the line in the transaction that stored it."""

    def cancel(self, fit_id: str) -> None:
        """Do nothing: the fit left the line, or its worker was told, in the transaction that dismissed it."""

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""
        told = asyncio.Event()
        self._waiting.setdefault(fit_id, set()).add(told)
        stopped = asyncio.create_task(self._stopped.wait())
        try:
            async with asyncio.timeout(seconds):
                while not self.stopping and not await self._ended(fit_id):
                    news = asyncio.create_task(told.wait())
                    await asyncio.wait((news, stopped), timeout=LOOK, return_when=asyncio.FIRST_COMPLETED)
                    news.cancel()
        except TimeoutError:
            return
        finally:
            stopped.cancel()
            self._waiting[fit_id].discard(told)
            if not self._waiting[fit_id]:
                del self._waiting[fit_id]

    async def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a running fit, as its worker last reported them."""
        with suppress(Exception):  # the fit itself was just read; its progress is worth no error
            return await asyncio.to_thread(self._store.progress, fit_id)
        return []

    async def drain(self, seconds: float) -> None:  # noqa: ARG002 - nothing runs here
        """Let everybody who waits for a fit go."""
        self._stopped.set()

    def hurry(self) -> None:
        """Do nothing: a drain takes no time here."""

    async def listen(self) -> None:
        """Hear which fits have ended, until cancelled."""
        while True:
            try:
                async with await psycopg.AsyncConnection.connect(self._url, autocommit=True) as connection:
                    await connection.execute(f"LISTEN {ENDED}")
                    async for word in connection.notifies():
                        for told in self._waiting.get(word.payload, ()):
                            told.set()
            except (psycopg.Error, OSError) as error:
                logger.warning("the database is not heard: %s", error)
            await asyncio.sleep(PAUSE)

    async def _ended(self, fit_id: str) -> bool:
        """Return whether there is nothing to wait for. While the store fails, there is."""
        with suppress(Exception):
            fit = await asyncio.to_thread(self._store.get, fit_id)
            return fit is None or fit.status.final
        return False
