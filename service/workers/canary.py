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


class Canary:
    """Fits a circle in each pool that has a worker with nothing to do; a pool whose workers all fit needs no proof."""

    def __init__(self, pools: Sequence[WorkerPool]) -> None:
        """Try the workers of these pools."""
        self._pools, self._fault = pools, "no fit was tried yet"

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
            await asyncio.sleep(SOONER_SECONDS if self._fault else PAUSE_SECONDS)

    async def try_now(self) -> None:
        """Try once."""
        try:
            for pool in self._pools:
                if pool.busy < pool.size:
                    await pool.run(tasks.fit_circle, deadline=MOST_SECONDS)
        except Exception as error:
            logger.exception("the workers cannot fit a circle")
            self._fault = f"{type(error).__name__}: {error}"
        else:
            self._fault = ""
