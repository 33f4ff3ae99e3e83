"""What the domain stores fits and point sets with, as Protocols. `service.bootstrap` connects the adapters."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

from service.jobs.admission import Admission, Usage
from service.jobs.caller import Caller, Quota
from service.jobs.fit import Failure, Fit, FitStatus
from service.jobs.lane_load import LaneLoad
from service.jobs.lease_holder import LeaseHolder
from service.jobs.page import Page

NO_QUOTA = Quota()


class FitStore(Protocol):
    """Stores fits durably. Every method is one transaction; one that `TRANSITIONS` forbids changes nothing."""

    def add(
        self, fit: Fit, store_input: Callable[[], object], parts: Sequence[Fit] = (), quota: Quota = NO_QUOTA
    ) -> tuple[Fit, Usage]:
        """Store a new fit with its parts and return it, or return the earlier fit with the same key and payload.

        Return, too, what waited before, and what the caller had of it.

        `store_input` is called while no other process can remove the same input. When this returns, the fit and its
        input survive a crash.

        Raises
        ------
        KeyReusedError
            If the earlier fit with this key has another payload.
        QueueFullError, QuotaExceededError
            If too many fits wait, of all callers or of this one.

        """

    def has_key(self, owner: str, key: str) -> bool:
        """Return whether a fit of this owner was stored with an idempotency key."""

    def usage(self, caller: Caller) -> Usage:
        """Return what waits, and what this caller has of it."""

    @property
    def admission(self) -> Admission:
        """Return the limits of the queue."""

    def get(self, fit_id: str) -> Fit | None:
        """Return the fit, or None."""

    def listed(self, page: Page, owner: str) -> Sequence[Fit]:
        """Return the fits of a page and an owner, without their results and their parts."""

    def start(self, fit_id: str, holder: LeaseHolder) -> Fit | None:
        """Set a waiting fit to running, on a lease, and return it with the number of the attempt; else None.

        A running fit whose lease has run out counts as waiting: its holder is dead. When its first part starts, the fit
        itself is set to running, too; when its last part has ended, it waits again, to be started itself.
        """

    def renew(self, fit_id: str, attempt: int, lease: float) -> bool:
        """Prolong the lease, if this attempt still holds the fit; return whether it does."""

    def release(self, fit_id: str, attempt: int, *, crashed: bool = False) -> bool:
        """Set a fit back to accepted, if this attempt still holds it; with `crashed`, count a crash."""

    def finish(
        self, fit_id: str, attempt: int, status: FitStatus, result: bytes | None, failure: Failure | None
    ) -> bool:
        """Set a fit to a final status with its result or failure, if this attempt still holds it.

        Its parts are removed. If it is itself a part, its fit has one part less to wait for, or fails with it.
        """

    def sums(self, fit_id: str) -> list[bytes]:
        """Return the results of the parts of a fit, in the order of their slices."""

    def dismiss(self, fit_id: str) -> bool:
        """Set a live fit to dismissed and remove its parts; return False if it has ended."""

    def remove(self, fit_id: str, delete_input: Callable[[str], object], *, keep_callback: bool = False) -> bool:
        """Remove a fit that has ended, and call `delete_input` with its input's key if no other fit has the same.

        Its callback goes with it; with `keep_callback`, not before it has been delivered or has failed.
        """

    def discard(self, key: str, delete_input: Callable[[str], object]) -> bool:
        """Call `delete_input` with a key that no fit has, while no fit with it can be added; return whether it was."""

    def unused(self, keys: Iterable[str]) -> list[str]:
        """Return those of the inputs' keys that no fit has."""

    def waiting(self) -> list[Fit]:
        """Return the accepted fits and parts that wait for a worker, oldest first."""

    def count_waiting(self) -> int:
        """Return how many fits wait for a worker, themselves or with a part."""

    def load(self) -> Sequence[LaneLoad]:
        """Return how much there is to do in each lane."""

    def recover(self) -> int:
        """Set every running fit back to accepted and return how many. Only for a store that no other process uses."""

    def report(self, fit_id: str, attempt: int, steps: list[dict[str, Any]]) -> bool:
        """Store the degrees tried so far, if this attempt still holds the fit; return whether it does."""

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees that were reported."""

    def outdated(self, age: float, size: int | None = None) -> list[str]:
        """Return ids of fits that ended `age` seconds ago, then of the oldest beyond `size` bytes of ended fits.

        The oldest are first; there may be more.
        """

    def forget_past(self) -> None:
        """Forget of clients and owners what has no effect any more: when fits were accepted, turns in the queue."""


class BlobStore(Protocol):
    """Stores bytes durably, each under its SHA-256. It can be pickled: workers read from it."""

    def put(self, content: bytes, key: str | None = None) -> str:
        """Store bytes, so that they survive a crash, and return the key; `key` is their SHA-256, if it is known."""

    def get(self, key: str, start: int | None = None, end: int | None = None) -> bytes:
        """Return the bytes under a key, or those from `start` to before `end`."""

    def delete(self, key: str) -> None:
        """Remove the bytes under a key, if there are any."""

    def keys(self) -> list[str]:
        """Return all keys."""
