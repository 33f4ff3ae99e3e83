"""When fits of each API key were accepted, in the last hour: its quota counts them, also when they were removed."""

from datetime import datetime, timedelta

from sqlalchemy import Connection, func, select

from service.jobs.admission import HOUR
from service.store.schema import acceptances


def add(connection: Connection, fit_id: str, owner: str, now: datetime) -> None:
    """Note that a fit is accepted now."""
    connection.execute(acceptances.insert().values(fit=fit_id, owner=owner, accepted=now))


def forget(connection: Connection, now: datetime) -> None:
    """Forget those of more than an hour ago, which no quota counts."""
    connection.execute(acceptances.delete().where(acceptances.c.accepted <= _an_hour_before(now)))


def recent(connection: Connection, owner: str, now: datetime) -> tuple[int, float]:
    """Return how many fits of an owner were accepted in the last hour, and the age of the first of them in seconds."""
    mine = (acceptances.c.owner == owner) & (acceptances.c.accepted > _an_hour_before(now))
    count, first = connection.execute(select(func.count(), func.min(acceptances.c.accepted)).where(mine)).one()
    return int(count), 0.0 if first is None else (now - first).total_seconds()


def _an_hour_before(now: datetime) -> datetime:
    return now - timedelta(seconds=HOUR)
