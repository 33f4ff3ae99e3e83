"""Callbacks in the transactions that add, end and remove their fits, so that none is lost or sent for nothing."""

from datetime import datetime
from typing import Any

from sqlalchemy import Connection, Row, bindparam, select, update

from service.jobs.callback import Callback, CallbackState
from service.jobs.fit import Fit, FitStatus
from service.store.schema import callbacks

# What a query for fits adds to its columns, in order to get their callbacks, too.
CALLBACK_COLUMNS = [callbacks.c[name].label(f"callback_{name}") for name in ("url", "state", "tries", "last_error")]
_DUE = (
    update(callbacks)
    .where(callbacks.c.fit == bindparam("of"))
    .values(status=bindparam("how"), ended=bindparam("when"), due=bindparam("when"))
)


def add(connection: Connection, fit: Fit) -> None:
    """Store the callback of a new fit, if it has one."""
    if fit.callback is None:
        return
    told = {"url": fit.callback.url, "host": fit.callback.host, "state": fit.callback.state.value, "tries": 0}
    connection.execute(callbacks.insert().values(fit=fit.id, client=fit.client, **told))


def of_row(row: Row[Any]) -> Callback | None:
    """Return the callback in a row that has `CALLBACK_COLUMNS`, if there is one."""
    if row.callback_url is None:
        return None
    return Callback(row.callback_url, CallbackState(row.callback_state), row.callback_tries, row.callback_last_error)


def make_due(connection: Connection, fit_id: str, status: FitStatus, ended: datetime) -> None:
    """Let the callback of a fit that ends, if it has one, be sent from now on."""
    connection.execute(_DUE, {"of": fit_id, "how": status, "when": ended})


def remove(connection: Connection, fit_id: str, *, keep_pending: bool) -> None:
    """Remove the callback of a fit that was removed in this transaction; perhaps not if it is still to be delivered.

    The row is locked first: `SqlCallbacks.record` may be about to end the callback, and looks whether its fit exists.
    """
    mine = callbacks.c.fit == fit_id
    state = connection.execute(select(callbacks.c.state).where(mine).with_for_update()).scalar()
    if not (keep_pending and state == CallbackState.PENDING):
        connection.execute(callbacks.delete().where(mine))
