"""The order in which the workers of a cluster take fits: fair between clients, by the predicted time of their fits.

This is start-time fair queueing (Goyal, Vin and Cheng, SIGCOMM 1996). The turn of a fit is the virtual time at which it
would start if all clients that have waiting fits were served at the same pace:

    turn = max(virtual time, turn + cost of the fit before of the same client)

The virtual time is the least turn of the fits that wait. Job queues have no turns, but places: whole numbers, the least
first, so a turn is rounded down, and counted from where the virtual time was when the cluster last had nothing to do.
`service.queue.fair_queue` is fair in the same way for one server, in memory.

A short fit goes to the lane that short fits have for themselves, unless another fit of its client is there: the lane is
for those who send few. When that one has ended, the next of the client takes its place there.
"""

from collections.abc import Sequence
from math import floor
from typing import Any

from sqlalchemy import Connection, bindparam, func, select
from sqlalchemy.dialects.postgresql import insert

from service.jobs.fit import SHORT_SECONDS, Fit, FitStatus
from service.store import mapping
from service.store.schema import fits, turns

# The last place that a job queue knows. A cluster that is never idle would get there in months; it then takes fits as
# they came, until nothing is left to do.
LAST_PLACE = 2**31 - 1
_LIVE = fits.c.status.in_([FitStatus.ACCEPTED, FitStatus.RUNNING])
_VIRTUAL_TIME = func.coalesce(
    # not those that were taken before, and wait because their points cannot be read: their turn is long past
    select(func.min(fits.c.turn)).where(*mapping.queued(), fits.c.attempt == 0).scalar_subquery(),
    select(func.max(fits.c.turn)).where(_LIVE).scalar_subquery(),
    select(func.max(turns.c.until)).scalar_subquery(),
    0.0,
)
_NOW = select(_VIRTUAL_TIME, select(func.max(func.floor(fits.c.turn) - fits.c.place)).where(_LIVE).scalar_subquery())
# One transaction at a time gives turns: two that saw the end of all work differently would count from different times.
_ALONE = select(func.pg_advisory_xact_lock(4_711_002))  # any number that has no other use
_IN_SHORT_LANE = select(fits.c.id).where(_LIVE, fits.c.short_lane, fits.c.client == bindparam("of")).limit(1)
_ADD = insert(turns).values(client=bindparam("of"), until=bindparam("now") + bindparam("cost"))
_TAKE = _ADD.on_conflict_do_update(
    index_elements=[turns.c.client],
    set_={"until": func.greatest(turns.c.until, bindparam("now")) + bindparam("cost")},
).returning(turns.c.until)


def take(connection: Connection, given: Sequence[Fit]) -> list[dict[str, Any]]:
    """Return the columns `turn`, `place` and `short_lane` of new fits of one client, which come one after the other."""
    connection.execute(_ALONE)
    virtual, began = connection.execute(_NOW).one()
    cost = sum(one.cost for one in given)
    until = connection.execute(_TAKE, {"of": given[0].client, "now": virtual, "cost": cost}).scalar_one()
    short = given[0].short and connection.execute(_IN_SHORT_LANE, {"of": given[0].client}).first() is None
    turn, columns = until - cost, []
    for one in given:
        place = floor(turn) - int(floor(virtual) if began is None else began)
        columns.append({"turn": turn, "place": max(-LAST_PLACE, min(place, LAST_PLACE)), "short_lane": short})
        turn += one.cost
    return columns


def give_back(connection: Connection, client: str, cost: float) -> None:
    """Take back the predicted time of a fit of a client that was dismissed before it was started."""
    connection.execute(turns.update().where(turns.c.client == client).values(until=turns.c.until - cost))


def next_in_short_lane(connection: Connection, client: str) -> Any:  # noqa: ANN401 - a row, or None
    """Return the row of the short fit of a client that may come to the lane of short fits, as none is there now."""
    mine = (fits.c.client == client, fits.c.status == FitStatus.ACCEPTED, fits.c.cost <= SHORT_SECONDS)
    waiting = select(fits.c.id, fits.c.job).where(*mine, fits.c.whole.is_(None), fits.c.parts == 0)
    return connection.execute(waiting.order_by(fits.c.turn).limit(1).with_for_update(skip_locked=True)).first()


def forget(connection: Connection) -> None:
    """Forget the clients whose next turn is now in any case."""
    connection.execute(_ALONE)
    connection.execute(turns.delete().where(turns.c.until <= _VIRTUAL_TIME))
