"""How long fits that have ended are kept."""

import asyncio
import logging
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from service.jobs.ports import BlobStore, FitStore

logger = logging.getLogger(__name__)

# Seconds between two looks.
PAUSE = 60.0


@dataclass(frozen=True)
class Retention:
    """Removes old fits, and the oldest when there are too many.

    Attributes
    ----------
    store, blobs
        Where they are.
    age
        Seconds that a fit is kept after its end.
    size
        Bytes that the inputs and results of ended fits may take together.

    """

    store: FitStore
    blobs: BlobStore
    age: float
    size: int

    def sweep(self) -> int:
        """Remove what need not be kept any longer; return how many."""
        before = datetime.now(UTC) - timedelta(seconds=self.age)
        return sum(self.store.remove(one, self.blobs.delete) for one in self.store.outdated(before, self.size))

    async def keep_sweeping(self) -> None:
        """Sweep now and then, until cancelled."""
        while True:
            try:
                if removed := await asyncio.to_thread(self.sweep):
                    logger.info("%d old fits were removed", removed)
            except Exception:
                logger.exception("old fits could not be removed; the next try is in %g s", PAUSE)
            await asyncio.sleep(PAUSE)
