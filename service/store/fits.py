"""The fit store in a SQL database, through SQLAlchemy Core."""

from collections.abc import Callable, Iterable, Sequence
from datetime import datetime, timedelta
from typing import Any

import orjson
from sqlalchemy import Connection, Engine, select
from sqlalchemy.exc import IntegrityError

from service.jobs.admission import Admission, Usage
from service.jobs.caller import Caller, Quota
from service.jobs.errors import KeyReusedError
from service.jobs.fit import Failure, Fit, FitStatus
from service.jobs.lane_load import LaneLoad
from service.jobs.lease_holder import LeaseHolder
from service.jobs.page import Page
from service.jobs.store_ports import NO_QUOTA
from service.store import acceptances, mapping, outbox, queries, transitions, turns
from service.store.input_locks import InputLocks
from service.store.schema import fits
from service.store.transitions import NOT_HELD, JobQueue

_INSERT = fits.insert()


class SqlFits:
    """The fit store. Every method is one transaction."""

    def __init__(self, engine: Engine, admission: Admission, queue: JobQueue | None = None) -> None:
        """Use an engine whose tables exist, let fits wait within limits, and keep `queue` up to date, if given."""
        self._engine, self.admission, self._queue = engine, admission, queue
        self._inputs = InputLocks(engine)

    def add(
        self, fit: Fit, store_input: Callable[[], object], parts: Sequence[Fit] = (), quota: Quota = NO_QUOTA
    ) -> tuple[Fit, Usage]:
        """Store a new fit with its parts and its input, unless it was stored before; return it, and what waited."""
        try:
            return self._add(fit, store_input, parts, quota)
        except IntegrityError:
            if fit.key is None:
                raise
            # finds the other fit with this key, which is committed by now
            return self._add(fit, store_input, parts, quota)

    def _add(
        self, fit: Fit, store_input: Callable[[], object], parts: Sequence[Fit], quota: Quota
    ) -> tuple[Fit, Usage]:
        with self._inputs.locked(fit.input.key) as connection:
            earlier, usage = self._earlier(connection, fit), queries.usage(connection, fit.client, fit.owner)
            if earlier is not None:
                return earlier, usage
            self.admission.check(usage, quota)
            store_input()
            places = [{}] * (1 + len(parts)) if self._queue is None else turns.take(connection, [*parts, fit])
            rows = [mapping.from_fit(one) | place for one, place in zip([*parts, fit], places, strict=True)]
            connection.execute(_INSERT, rows)
            if fit.owner:
                acceptances.add(connection, fit.id, fit.owner, transitions.clock(connection))
            outbox.add(connection, fit)
            if self._queue is not None:
                for one, place in zip(parts or [fit], places, strict=False):
                    transitions.enqueue(connection, self._queue, one.id, place["place"], short=place["short_lane"])
        return fit, usage

    def has_key(self, owner: str, key: str) -> bool:
        """Return whether a fit of this owner was stored with an idempotency key."""
        with self._engine.connect() as connection:
            return queries.has_key(connection, mapping.stored_key(owner, key))

    def usage(self, caller: Caller) -> Usage:
        """Return what waits, and what this caller has of it."""
        with self._engine.connect() as connection:
            return queries.usage(connection, caller.client, caller.owner)

    def get(self, fit_id: str) -> Fit | None:
        """Return the fit, or None."""
        with self._engine.connect() as connection:
            return queries.fit(connection, fit_id)

    def listed(self, page: Page, owner: str) -> Sequence[Fit]:
        """Return the fits of a page and an owner, without their results and their parts."""
        with self._engine.connect() as connection:
            return [mapping.to_fit(row) for row in queries.page(connection, page, owner)]

    def start(self, fit_id: str, holder: LeaseHolder) -> Fit | None:
        """Set a waiting fit to running, on a lease, and return it, or None if it does not wait."""
        with self._engine.begin() as connection:
            transitions.lock_whole(connection, fit_id)
            now = transitions.clock(connection)
            if not self._started(connection, fit_id, holder, now):
                abandoned = (fits.c.id == fit_id, fits.c.lease < now)
                if not transitions.requeue_abandoned(connection, self._queue, *abandoned):
                    return None
                if not self._started(connection, fit_id, holder, now):
                    return None
            fit = queries.fit(connection, fit_id)
            if fit is not None and fit.whole is not None:
                transitions.transition(connection, self._queue, fit.whole, FitStatus.RUNNING, {"started": now})
            return fit

    def _started(self, connection: Connection, fit_id: str, holder: LeaseHolder, now: datetime) -> bool:
        """Set an accepted fit to running, unless it waits for its parts; return whether it was set."""
        lease = {"holder": holder.name, "lease": now + timedelta(seconds=holder.lease)}
        values = {"started": now, "progress": None, **lease}
        more = {"attempt": 1}
        running = FitStatus.RUNNING
        return transitions.transition(connection, self._queue, fit_id, running, values, more=more, summed=True)

    def renew(self, fit_id: str, attempt: int, lease: float) -> bool:
        """Prolong the lease, if this attempt still holds the fit; return whether it does."""
        with self._engine.begin() as connection:
            until = transitions.clock(connection) + timedelta(seconds=lease)
            return mapping.update_where(connection, mapping.held_by(fit_id, attempt), lease=until)

    def report(self, fit_id: str, attempt: int, steps: list[dict[str, Any]]) -> bool:
        """Store the degrees tried so far, if this attempt still holds the fit; return whether it does."""
        with self._engine.begin() as connection:
            return mapping.update_where(connection, mapping.held_by(fit_id, attempt), progress=orjson.dumps(steps))

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees that were reported."""
        with self._engine.connect() as connection:
            return queries.progress(connection, fit_id)

    def release(self, fit_id: str, attempt: int, *, crashed: bool = False) -> bool:
        """Set a fit back to accepted, if this attempt still holds it; with `crashed`, count a crash."""
        values, more = {"started": None, "progress": None, **NOT_HELD}, {"crashes": int(crashed)}
        with self._engine.begin() as connection:
            back = FitStatus.ACCEPTED
            return transitions.transition(connection, self._queue, fit_id, back, values, more=more, attempt=attempt)

    def finish(
        self, fit_id: str, attempt: int, status: FitStatus, result: bytes | None, failure: Failure | None
    ) -> bool:
        """Set a fit to a final status with its result or failure, if this attempt still holds it."""
        reason = None if failure is None else orjson.dumps(failure)
        more = {"size": len(result or b"")}
        with self._engine.begin() as connection:
            transitions.lock_whole(connection, fit_id)
            values = {"result": result, "failure": reason, "finished": transitions.clock(connection), **NOT_HELD}
            return transitions.transition(connection, self._queue, fit_id, status, values, more=more, attempt=attempt)

    def sums(self, fit_id: str) -> list[bytes]:
        """Return the results of the parts of a fit, in the order of their slices."""
        with self._engine.connect() as connection:
            return queries.sums(connection, fit_id)

    def dismiss(self, fit_id: str) -> bool:
        """Set a live fit to dismissed and remove its parts; return False if it has ended."""
        with self._engine.begin() as connection:
            values = {"finished": transitions.clock(connection), **NOT_HELD}
            done = transitions.transition(connection, self._queue, fit_id, FitStatus.DISMISSED, values)
            job = connection.execute(select(fits.c.job).where(fits.c.id == fit_id)).scalar()
            if done and self._queue is not None and job is not None:
                self._queue.cancel(connection, job)
            return done

    def remove(self, fit_id: str, delete_input: Callable[[str], object], *, keep_callback: bool = False) -> bool:
        """Remove a fit that has ended, and delete its input if no other fit has the same."""
        ended = (fits.c.id == fit_id) & fits.c.status.in_(queries.ENDED) & fits.c.whole.is_(None)
        with self._engine.begin() as connection:
            key = connection.execute(select(fits.c.input).where(ended)).scalar()
            if connection.execute(fits.delete().where(ended)).rowcount:
                outbox.remove(connection, fit_id, keep_pending=keep_callback)
        if key is None:
            return False
        self.discard(key, delete_input)  # after the row, so that no fit ever lacks its points
        return True

    def discard(self, key: str, delete_input: Callable[[str], object]) -> bool:
        """Delete an input that no fit has, while no fit with it can be added; return whether it was."""
        with self._inputs.locked(key, exclusive=True) as connection:
            used = queries.has_input(connection, key)
            if not used:
                delete_input(key)
        return not used

    def unused(self, keys: Iterable[str]) -> list[str]:
        """Return those of the inputs' keys that no fit has."""
        with self._engine.connect() as connection:
            return queries.unused(connection, keys)

    def waiting(self) -> list[Fit]:
        """Return the accepted fits and parts that wait for a worker, oldest first."""
        with self._engine.connect() as connection:
            return [mapping.to_fit(row) for row in queries.waiting(connection)]

    def count_waiting(self) -> int:
        """Return how many fits wait for a worker, themselves or with a part."""
        with self._engine.connect() as connection:
            return queries.count_waiting(connection)

    def load(self) -> list[LaneLoad]:
        """Return how much there is to do in each lane."""
        with self._engine.connect() as connection:
            return queries.load(connection)

    def recover(self) -> int:
        """Set every running fit back to accepted and return how many; the server that ran them is gone."""
        with self._engine.begin() as connection:
            return transitions.requeue_abandoned(connection, self._queue)

    def requeue_lost(self, seconds: float) -> int:
        """Give a new job to each live fit that has none and that no process has held for `seconds`; return how many.

        A fit loses its job only if a connection is cut while the end of the job is being stored.
        """
        if self._queue is None:
            return 0
        with self._engine.begin() as connection:
            return transitions.requeue_lost(connection, self._queue, seconds)

    def outdated(self, age: float, size: int | None = None) -> list[str]:
        """Return ids of fits that ended `age` seconds ago, and then of the oldest beyond `size` bytes of ended fits."""
        with self._engine.connect() as connection:
            return queries.outdated(connection, age, size)

    def forget_past(self) -> None:
        """Forget of clients and owners what has no effect any more: when fits were accepted, turns in the queue."""
        with self._engine.begin() as connection:
            acceptances.forget(connection, transitions.clock(connection))
            if self._queue is not None:
                turns.forget(connection)

    def _earlier(self, connection: Connection, fit: Fit) -> Fit | None:
        """Return the fit that was stored with the same key, if this one has a key."""
        if fit.key is None:
            return None
        earlier = queries.fit_of_key(connection, mapping.stored_key(fit.owner, fit.key))
        if earlier is not None and earlier.payload != fit.payload:
            raise KeyReusedError(
                "this Idempotency-Key came before, with another point set, other options or another callback"
            )
        return earlier
