"""Callbacks in the transactions that add, end and remove their fits, so that none is lost or sent for nothing."""

from datetime import datetime

from sqlalchemy import Connection, select, update

from service.jobs.callback import Callback, CallbackState
from service.jobs.fit import Fit, FitStatus
from service.store.schema import callbacks


def add(connection: Connection, fit: Fit) -> None:
    """Store the callback of a new fit, if it has one."""
    if fit.callback is None:
        return
    told = {"url": fit.callback.url, "host": fit.callback.host, "state": fit.callback.state.value, "tries": 0}
    connection.execute(callbacks.insert().values(fit=fit.id, client=fit.client, **told))


def of_fit(connection: Connection, fit_id: str) -> Callback | None:
    """Return the callback of a fit, if it has one."""
    row = connection.execute(select(callbacks).where(callbacks.c.fit == fit_id)).one_or_none()
    return None if row is None else Callback(row.url, CallbackState(row.state), row.tries, row.last_error)


def make_due(connection: Connection, fit_id: str, status: FitStatus, ended: datetime) -> None:
    """Let the callback of a fit that ends, if it has one, be sent from now on."""
    mine = update(callbacks).where(callbacks.c.fit == fit_id)
    connection.execute(mine.values(status=status, ended=ended, due=ended))


def remove(connection: Connection, fit_id: str, *, keep_pending: bool) -> None:
    """Remove the callback of a fit that was removed in this transaction; perhaps not if it is still to be delivered.

    The row is locked first: `SqlCallbacks.record` may be about to end the callback, and looks whether its fit exists.
    """
    mine = callbacks.c.fit == fit_id
    state = connection.execute(select(callbacks.c.state).where(mine).with_for_update()).scalar()
    if not (keep_pending and state == CallbackState.PENDING):
        connection.execute(callbacks.delete().where(mine))
