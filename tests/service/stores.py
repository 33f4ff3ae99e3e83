"""Fits to store, and their jobs in the queue of the same database."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Engine, text

from service.jobs.fit import Fit, FitStatus, PointSetRef
from service.jobs.lease_holder import LeaseHolder
from service.jobs.requested_options import RequestedOptions
from service.queue.procrastinate_jobs import make, steps
from service.store.fits import SqlFits
from service.store.migrations import MigrationStep

LIMIT = 40
QUEUE = MigrationStep("procrastinate", "procrastinate_jobs", make, steps())
ME, OTHER = LeaseHolder("me", 60.0), LeaseHolder("other", 60.0)
NOW = datetime(2026, 11, 22, 20, 15, 30, 123456, UTC)


def fit(fit_id: str = "one", blob: str = "b10b", created: datetime = NOW, **more: Any) -> Fit:  # noqa: ANN401 - any
    return Fit(
        fit_id, FitStatus.ACCEPTED, PointSetRef(blob, 3, 100, 1000), RequestedOptions({"t1": 0.02}), created, **more
    )


def add(store: SqlFits, new: Fit) -> Fit:
    return store.add(new, list)[0]


def start(store: SqlFits, fit_id: str, holder: LeaseHolder) -> int | None:
    """Start a fit and return the number of the attempt, or None."""
    started = store.start(fit_id, holder)
    return None if started is None else started.attempt


def jobs(engine: Engine) -> list[str]:
    with engine.connect() as connection:
        return list(connection.execute(text("SELECT status FROM procrastinate_jobs ORDER BY id")).scalars())
