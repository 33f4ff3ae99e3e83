"""The store of callbacks, in the database of the fits."""

from collections.abc import Collection
from datetime import timedelta

from sqlalchemy import Engine, select, update

from service.jobs.callback import CallbackState
from service.jobs.delivery import Delivery, Outcome
from service.store.schema import callbacks, fits
from service.store.transitions import clock


class SqlCallbacks:
    """The store of callbacks. Every method is one transaction."""

    def __init__(self, engine: Engine) -> None:
        """Use an engine whose tables exist."""
        self._engine = engine

    def take_due(self, hosts: Collection[str], clients: Collection[str], lease: float) -> Delivery | None:
        """Take the callback that has been due for longest, to none of these hosts and of none of these clients.

        Return None if there is none.

        Of processes that look at the same time, each takes another one: PostgreSQL skips the rows that others have
        locked, and on SQLite the second does not find the number of tries that it has seen.
        """
        with self._engine.begin() as connection:
            now = clock(connection)
            free = (callbacks.c.host.not_in(list(hosts)), callbacks.c.client.not_in(list(clients)))
            due = select(callbacks).where(callbacks.c.due <= now, *free)
            oldest = due.order_by(callbacks.c.due, callbacks.c.fit).limit(1).with_for_update(skip_locked=True)
            row = connection.execute(oldest).one_or_none()
            if row is None:
                return None
            mine = (callbacks.c.fit == row.fit) & (callbacks.c.tries == row.tries)
            taken = {"tries": row.tries + 1, "due": now + timedelta(seconds=lease)}
            if not connection.execute(update(callbacks).where(mine).values(taken)).rowcount:
                return None
        return Delivery(row.fit, row.url, row.host, row.client, row.status, row.ended, row.tries + 1, row.last_error)

    def record(self, delivery: Delivery, outcome: Outcome) -> bool:
        """Store what came of a try, unless it was taken again meanwhile; return whether it was stored.

        The callback of a fit that was removed meanwhile is removed when it has ended: nobody can ask for it.
        """
        mine = (callbacks.c.fit == delivery.fit_id) & (callbacks.c.tries == delivery.tries)
        with self._engine.begin() as connection:
            again = outcome.state is CallbackState.PENDING
            due = clock(connection) + timedelta(seconds=outcome.pause) if again else None
            values = {"state": outcome.state.value, "last_error": outcome.error, "due": due}
            done = connection.execute(update(callbacks).where(mine, callbacks.c.due.is_not(None)).values(values))
            if not again:
                fit = select(fits.c.id).where(fits.c.id == delivery.fit_id)
                connection.execute(callbacks.delete().where(mine, ~fit.exists()))
        return bool(done.rowcount)
