"""Removing fits that ended long ago, and point sets that belong to no fit."""

import asyncio
import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from service.jobs.store_ports import BlobStore, FitStore

logger = logging.getLogger(__name__)

# Seconds between two removals of old fits.
SWEEP_SECONDS = 60.0
# Seconds between two looks at the size of all ended fits, for which the database reads a row of each.
SIZE_SECONDS = 50.0
# Seconds after which a removal of old fits leaves the rest to the next one: a program that stops waits for it.
LONGEST_SWEEP = 2.0
# Seconds between two removals of point sets without a fit, for which all point sets have to be listed.
ORPHAN_SECONDS = 3600.0


@dataclass
class Retention:
    """Removes ended fits that are too old, and the oldest when all of them together are too large.

    Attributes
    ----------
    store, blobs
        The fits, and their point sets.
    age
        Seconds that a fit is kept after its end.
    size
        Bytes that the point sets and results of ended fits may take together.
    exclusive
        Whether no other store keeps point sets in the same place. If one does, a point set without a fit in this store
        may belong to a fit in the other one, and is left there.

    """

    store: FitStore
    blobs: BlobStore
    age: float
    size: int
    exclusive: bool = False
    _orphans_removed: float = field(default=float("-inf"), init=False)
    _sized: float = field(default=float("-inf"), init=False)

    def sweep(self) -> tuple[int, bool]:
        """Remove fits that need not be kept any longer, for a moment; return how many, and whether there are more.

        A callback that could not be delivered yet is tried further: it is small, and was promised.
        """
        end = time.monotonic() + LONGEST_SWEEP
        self.store.forget_past()
        outdated, removed = self._outdated(), 0
        for tried, one in enumerate(outdated, start=1):
            removed += self.store.remove(one, self.blobs.delete, keep_callback=True)
            if tried < len(outdated) and time.monotonic() > end:
                self._sized = float("-inf")  # the size is looked at again when the next sweep goes on
                return removed, True
        if self.exclusive and time.monotonic() > self._orphans_removed + ORPHAN_SECONDS:
            self._remove_orphans()
        return removed, False

    def _outdated(self) -> Sequence[str]:
        """Return the oldest fits that need not be kept: for their age, or now and then for the size of all."""
        if time.monotonic() < self._sized + SIZE_SECONDS:
            return self.store.outdated(self.age)
        self._sized = time.monotonic()
        return self.store.outdated(self.age, self.size)

    def _remove_orphans(self) -> None:
        """Remove point sets that belong to no fit: a crash between storing the two leaves them."""
        unused = self.store.unused(self.blobs.keys())
        removed = sum(self.store.discard(key, self.blobs.delete) for key in unused)
        self._orphans_removed = time.monotonic()
        if removed:
            logger.warning("%d point sets without a fit were removed", removed)

    async def keep_sweeping(self) -> None:
        """Sweep again and again, until cancelled."""
        while True:
            more = False
            try:
                removed, more = await asyncio.to_thread(self.sweep)
                if removed:
                    logger.info("%d old fits were removed", removed)
            except Exception:
                logger.exception("old fits could not be removed; the next try is in %g s", SWEEP_SECONDS)
            await asyncio.sleep(0.0 if more else SWEEP_SECONDS)
