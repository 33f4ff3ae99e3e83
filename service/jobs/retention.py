"""How long fits that have ended are kept."""

import asyncio
import logging
import time
from dataclasses import dataclass, field

from service.jobs.ports import BlobStore, FitStore

logger = logging.getLogger(__name__)

# Seconds between two looks …
PAUSE = 60.0
# … and between two looks for point sets without a fit, for which all of them are listed.
CLEARING = 3600.0


@dataclass
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
    alone
        Whether the store is the only one that keeps its point sets in this place. Elsewhere, those without a fit may be
        another's.

    """

    store: FitStore
    blobs: BlobStore
    age: float
    size: int
    alone: bool = False
    _cleared: float = field(default=float("-inf"), init=False)

    def sweep(self) -> int:
        """Remove what need not be kept any longer; return how many."""
        removed = sum(self.store.remove(one, self.blobs.delete) for one in self.store.outdated(self.age, self.size))
        if self.alone and time.monotonic() > self._cleared + CLEARING:
            self._clear()
        return removed

    def _clear(self) -> None:
        """Remove point sets that no fit has: a crash between the two left them."""
        left = sum(self.store.discard(key, self.blobs.delete) for key in self.store.unused(self.blobs.keys()))
        self._cleared = time.monotonic()
        if left:
            logger.warning("%d point sets that no fit had were removed", left)

    async def keep_sweeping(self) -> None:
        """Sweep now and then, until cancelled."""
        while True:
            try:
                if removed := await asyncio.to_thread(self.sweep):
                    logger.info("%d old fits were removed", removed)
            except Exception:
                logger.exception("old fits could not be removed; the next try is in %g s", PAUSE)
            await asyncio.sleep(PAUSE)
