"""A tiny fit, now and then, that shows whether the workers can fit."""

import asyncio
import logging
from collections.abc import Sequence

from service.jobs.errors import NotReadyError
from service.workers import tasks
from service.workers.pool import WorkerPool

logger = logging.getLogger(__name__)

# Seconds between two tries, and that one may take: most take hundredths.
PAUSE_SECONDS, MOST_SECONDS = 30.0, 10.0
# Seconds between two tries after one that failed.
SOONER_SECONDS = 2.0
MOST_FAILURES = 2  # in a row
UNTRIED = "no fit was tried yet"


class Canary:
    """Fits a circle in each pool that has a worker with nothing to do; a pool whose workers all fit needs no proof."""

    def __init__(self, pools: Sequence[WorkerPool]) -> None:
        """Try the workers of these pools."""
        self._pools, self._fault, self._failures = pools, UNTRIED, 0

    def check(self) -> None:
        """Do nothing if the last fit came out as it should.

        Raises
        ------
        NotReadyError
            If not; its message is the reason.

        """
        if self._fault:
            raise NotReadyError(f"the workers cannot fit: {self._fault}")

    async def keep_trying(self) -> None:
        """Try again and again, until cancelled."""
        while True:
            await self.try_now()
            await asyncio.sleep(SOONER_SECONDS if self._fault or self._failures else PAUSE_SECONDS)

    async def try_now(self) -> None:
        """Try once. What cannot begin, because a disk is full or no worker is idle, shows nothing."""
        idle = [pool for pool in self._pools if pool.busy < pool.size]
        try:
            for pool in idle:
                await pool.run(tasks.fit_circle, deadline=MOST_SECONDS)
        except NotReadyError:
            return
        except Exception as error:  # noqa: BLE001 - whatever stands in the way of fitting
            self._failed(error)
        else:
            if idle or self._fault == UNTRIED:
                self._fault, self._failures = "", 0

    def _failed(self, error: Exception) -> None:
        """Count a failure. One alone may be chance, on a machine that is too busy."""
        self._failures += 1
        if self._failures >= MOST_FAILURES or self._fault == UNTRIED:
            fault = f"{type(error).__name__}: {error}"
            if fault != self._fault:
                logger.error("the workers cannot fit a circle", exc_info=error)
            self._fault = fault
