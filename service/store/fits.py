"""Fits in a SQL database, through SQLAlchemy Core."""

from collections.abc import Callable, Iterable, Sequence
from datetime import timedelta
from typing import Any

import orjson
from sqlalchemy import Connection, Engine, func, select
from sqlalchemy.exc import IntegrityError

from service.jobs.errors import KeyReusedError, QueueFullError
from service.jobs.fit import Failure, Fit, FitStatus, Holder
from service.store import mapping, transitions
from service.store.input_locks import InputLocks
from service.store.schema import fits
from service.store.transitions import FREE, JobQueue

ENDED = [status for status in FitStatus if status.final]


class SqlFits:
    """The fit store. Every method is one transaction; a move names the statuses it may start from, in its WHERE."""

    def __init__(self, engine: Engine, limit: int, line: JobQueue | None = None) -> None:
        """Use an engine whose tables exist; let at most `limit` fits wait; tell `line` of what comes and goes."""
        self._engine, self._limit, self._line = engine, limit, line
        self._inputs = InputLocks(engine)

    def add(self, fit: Fit, keep: Callable[[], object], parts: Sequence[Fit] = ()) -> Fit:
        """Store a new fit with its parts and its input, unless it was stored before."""
        try:
            return self._add(fit, keep, parts)
        except IntegrityError:
            if fit.key is None:
                raise
            return self._add(fit, keep, parts)  # whoever came first with this key has committed by now, and is found

    def _add(self, fit: Fit, keep: Callable[[], object], parts: Sequence[Fit]) -> Fit:
        with self._inputs.held(fit.input.key) as connection:
            earlier = self._earlier(connection, fit)
            if earlier is not None:
                return earlier
            self._check_room(connection)
            keep()
            connection.execute(fits.insert(), [mapping.from_fit(one) for one in (fit, *parts)])
            if self._line is not None:
                for one in parts or [fit]:
                    transitions.join(connection, self._line, one)
        return fit

    def get(self, fit_id: str) -> Fit | None:
        """Return the fit, or None."""
        with self._engine.connect() as connection:
            row = connection.execute(select(fits).where(fits.c.id == fit_id)).one_or_none()
        return None if row is None else mapping.to_fit(row)

    def start(self, fit_id: str, holder: Holder) -> int | None:
        """Move to running, on a lease, and return the attempt, from 1; None if the fit does not wait."""
        with self._engine.begin() as connection:
            transitions.hold_whole(connection, fit_id)
            now = transitions.clock(connection)
            transitions.take_back(connection, self._line, fits.c.id == fit_id, fits.c.lease < now)
            if connection.execute(select(fits.c.unsummed).where(fits.c.id == fit_id)).scalar():
                return None
            values = {
                "started": now,
                "holder": holder.name,
                "lease": now + timedelta(seconds=holder.lease),
                "progress": None,
                "attempt": fits.c.attempt + 1,
            }
            if not transitions.move(connection, self._line, fit_id, FitStatus.RUNNING, values):
                return None
            fit = mapping.to_fit(connection.execute(select(fits).where(fits.c.id == fit_id)).one())
            if fit.whole is not None:
                transitions.move(connection, self._line, fit.whole, FitStatus.RUNNING, {"started": now})
            return fit.attempt

    def renew(self, fit_id: str, attempt: int, lease: float) -> bool:
        """Prolong the lease, if this attempt still holds the fit."""
        with self._engine.begin() as connection:
            until = transitions.clock(connection) + timedelta(seconds=lease)
            return mapping.written(connection, mapping.held(fit_id, attempt), lease=until)

    def report(self, fit_id: str, attempt: int, steps: list[dict[str, Any]]) -> bool:
        """Keep the degrees tried so far, if this attempt still holds the fit."""
        with self._engine.begin() as connection:
            return mapping.written(connection, mapping.held(fit_id, attempt), progress=orjson.dumps(steps))

    def progress(self, fit_id: str) -> list[dict[str, Any]]:
        """Return the degrees that were reported."""
        with self._engine.connect() as connection:
            kept = connection.execute(select(fits.c.progress).where(fits.c.id == fit_id)).scalar()
        steps: list[dict[str, Any]] = [] if kept is None else orjson.loads(kept)
        return steps

    def release(self, fit_id: str, attempt: int, *, crashed: bool = False) -> bool:
        """Move from running back to accepted, if this attempt still holds the fit; count a crash if it was one."""
        values = {"started": None, "progress": None, "crashes": fits.c.crashes + int(crashed), **FREE}
        with self._engine.begin() as connection:
            return transitions.move(connection, self._line, fit_id, FitStatus.ACCEPTED, values, attempt)

    def finish(
        self, fit_id: str, attempt: int, status: FitStatus, result: bytes | None, failure: Failure | None
    ) -> bool:
        """Move to a final status with its result or failure, if this attempt still holds the fit."""
        reason = None if failure is None else orjson.dumps(failure)
        size = fits.c.size + len(result or b"")
        with self._engine.begin() as connection:
            transitions.hold_whole(connection, fit_id)
            values = {"result": result, "failure": reason, "size": size, "finished": transitions.clock(connection)}
            return transitions.move(connection, self._line, fit_id, status, values | FREE, attempt)

    def sums(self, fit_id: str) -> list[bytes]:
        """Return what the parts of a fit resulted in, in their order."""
        query = select(fits.c.result).where(fits.c.whole == fit_id, fits.c.status == FitStatus.SUCCESSFUL)
        with self._engine.connect() as connection:
            return list(connection.execute(query.order_by(fits.c.id)).scalars())

    def dismiss(self, fit_id: str) -> bool:
        """Move to dismissed, if the fit is live; its parts go."""
        with self._engine.begin() as connection:
            values = {"finished": transitions.clock(connection), **FREE}
            moved = transitions.move(connection, self._line, fit_id, FitStatus.DISMISSED, values)
            job = connection.execute(select(fits.c.job).where(fits.c.id == fit_id)).scalar()
            if moved and self._line is not None and job is not None:
                self._line.leave(connection, job)
            return moved

    def remove(self, fit_id: str, drop: Callable[[str], object]) -> bool:
        """Forget a fit that has ended, and drop its input if no other fit has the same."""
        ended = (fits.c.id == fit_id) & fits.c.status.in_(ENDED) & fits.c.whole.is_(None)
        with self._engine.begin() as connection:
            key = connection.execute(select(fits.c.input).where(ended)).scalar()
            connection.execute(fits.delete().where(ended))
        if key is None:
            return False
        self.discard(key, drop)  # the row went first: if this fails, a blob is left, and not a fit without its points
        return True

    def discard(self, key: str, drop: Callable[[str], object]) -> bool:
        """Drop an input, if no fit has it and none can be coming with it."""
        with self._inputs.held(key, alone=True) as connection:
            used = connection.execute(select(fits.c.id).where(fits.c.input == key).limit(1)).first() is not None
            if not used:
                drop(key)
        return not used

    def unused(self, keys: Iterable[str]) -> list[str]:
        """Return those of the inputs that no fit has."""
        with self._engine.connect() as connection:
            used = set(connection.execute(select(fits.c.input).distinct()).scalars())
        return [key for key in keys if key not in used]

    def waiting(self) -> list[Fit]:
        """Return the accepted fits and parts that are in line, oldest first."""
        query = select(fits).where(*mapping.in_line()).order_by(fits.c.created, fits.c.id)
        with self._engine.connect() as connection:
            return [mapping.to_fit(row) for row in connection.execute(query)]

    def count_waiting(self) -> int:
        """Return how many fits are in line."""
        with self._engine.connect() as connection:
            return mapping.backlog(connection)[0]

    def recover(self) -> int:
        """Move every running fit back to accepted; the server that ran them is gone."""
        with self._engine.begin() as connection:
            return transitions.take_back(connection, self._line)

    def rejoin(self, seconds: float) -> int:
        """Put live fits in line again that nobody has held for so long and that have no job there; return how many.

        There should be none. But a connection may be cut in the very moment in which a job's end is written down.
        """
        if self._line is None:
            return 0
        with self._engine.begin() as connection:
            return transitions.rejoin(connection, self._line, seconds)

    def outdated(self, age: float, size: int) -> list[str]:
        """Return the ids of fits that ended `age` seconds ago, and of the oldest beyond `size` bytes of ended fits."""
        newest_first = func.sum(fits.c.size).over(order_by=(fits.c.finished.desc(), fits.c.id))
        ended = select(fits.c.id, fits.c.finished, newest_first.label("total"))
        each = ended.where(fits.c.status.in_(ENDED), fits.c.whole.is_(None)).subquery()  # parts go with their fits
        with self._engine.connect() as connection:
            before = transitions.clock(connection) - timedelta(
                seconds=age
            )  # of the clock that wrote down when they ended
            too_much = (each.c.finished < before) | (each.c.total > size)
            return list(connection.execute(select(each.c.id).where(too_much).order_by(each.c.finished)).scalars())

    def _earlier(self, connection: Connection, fit: Fit) -> Fit | None:
        """Return the fit that came with the same key, if this one has a key."""
        if fit.key is None:
            return None
        row = connection.execute(select(fits).where(fits.c.key == fit.key)).one_or_none()
        if row is not None and row.payload != fit.payload:
            raise KeyReusedError("this Idempotency-Key came before, with another point set or other options")
        return None if row is None else mapping.to_fit(row)

    def _check_room(self, connection: Connection) -> None:
        count, cost = mapping.backlog(connection)
        if count >= self._limit:
            raise QueueFullError(f"{count} fits wait already, as many as may", retry_after=cost / count)
