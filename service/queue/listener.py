"""The queue for a stateless API process: other processes run the fits, and PostgreSQL notifies when one has ended."""

import asyncio
import logging
from contextlib import suppress
from typing import Any

import psycopg

from service.jobs.fit import Fit
from service.jobs.store_ports import FitStore
from service.queue.procrastinate_jobs import ENDED_CHANNEL

logger = logging.getLogger(__name__)

# Seconds between two looks at the store while somebody waits for a fit: a notification may be lost with its connection.
FALLBACK_POLL_SECONDS = 2.0
# Seconds before a broken connection is opened again.
LISTEN_AGAIN_SECONDS = 1.0


class FitListener:
    """Waits for the end of fits that were queued when they were stored."""

    def __init__(self, store: FitStore, url: str) -> None:
        """Listen to the database at `url`."""
        self._store, self._url = store, url
        self._waiting: dict[str, set[asyncio.Event]] = {}
        self._stopped = asyncio.Event()

    @property
    def stopping(self) -> bool:
        """Return whether the server is about to stop; nothing new is to be accepted then."""
        return self._stopped.is_set()

    def submit(self, fit: Fit) -> None:
        """Do nothing: the transaction that stored the fit queued it."""

    def cancel(self, fit_id: str) -> None:
        """Do nothing: the transaction that dismissed the fit removed its job, or told its worker to abort."""

    async def wait(self, fit_id: str, seconds: float) -> None:
        """Return when the fit has ended, the time is up, or the server is about to stop."""
        notified = asyncio.Event()
        self._waiting.setdefault(fit_id, set()).add(notified)
        stopped = asyncio.create_task(self._stopped.wait())
        try:
            async with asyncio.timeout(seconds):
                while not self.stopping and not await self._ended(fit_id):
                    notification = asyncio.create_task(notified.wait())
                    await asyncio.wait(
                        (notification, stopped), timeout=FALLBACK_POLL_SECONDS, return_when=asyncio.FIRST_COMPLETED
                    )
                    notification.cancel()
        except TimeoutError:
            return
        finally:
            stopped.cancel()
            self._waiting[fit_id].discard(notified)
            if not self._waiting[fit_id]:
                del self._waiting[fit_id]

    async def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees tried so far by a running fit, as its worker last reported them."""
        with suppress(Exception):  # the fit itself was read before; missing progress is not worth an error
            return await asyncio.to_thread(self._store.progress, fit_id)
        return []

    async def drain(self, seconds: float) -> None:  # noqa: ARG002 - nothing runs here
        """End every `wait`."""
        self._stopped.set()

    def end_drain(self) -> None:
        """Do nothing: a drain takes no time here."""

    async def listen(self) -> None:
        """Receive the notifications about fits that have ended, until cancelled."""
        while True:
            try:
                async with await psycopg.AsyncConnection.connect(self._url, autocommit=True) as connection:
                    await connection.execute(f"LISTEN {ENDED_CHANNEL}")
                    async for notification in connection.notifies():
                        for notified in self._waiting.get(notification.payload, ()):
                            notified.set()
            except (psycopg.Error, OSError) as error:
                logger.warning("the database cannot be listened to: %s", error)
            await asyncio.sleep(LISTEN_AGAIN_SECONDS)

    async def _ended(self, fit_id: str) -> bool:
        """Return whether the fit has ended or does not exist; False while the store fails."""
        with suppress(Exception):
            fit = await asyncio.to_thread(self._store.get, fit_id)
            return fit is None or fit.status.final
        return False
