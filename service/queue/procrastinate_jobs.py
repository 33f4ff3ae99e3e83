"""The line of fits in PostgreSQL: Procrastinate's jobs, changed in the transactions that change the fits."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from procrastinate import App, SyncPsycopgConnector
from procrastinate.schema import SchemaManager
from sqlalchemy import Connection, text

TASK = "fit"
SHORT_QUEUE, LONG_QUEUE = "short", "long"
# Seconds within which a job comes that is to be tried again. If it is set for later, and its fit is not held, the clock
# of the machine that set it was wrong.
AHEAD = 120.0
# Where the ids of fits that have ended are told (PostgreSQL's NOTIFY).
ENDED = "ipfit_ended"


class ProcrastinateJobs:
    """Puts fits in Procrastinate's queues and takes them out, on the connection of whoever stores the change."""

    def __init__(self) -> None:
        """Need no connection of its own."""
        self._app = App(connector=SyncPsycopgConnector())

    def join(self, connection: Connection, fit_id: str, *, short: bool) -> int:
        """Put a fit in line, or in that of the short, and return its job there."""
        queue = SHORT_QUEUE if short else LONG_QUEUE
        deferrer = self._app.configure_task(TASK, queue=queue, connection=_raw(connection))
        return deferrer.defer(fit_id=fit_id)

    def leave(self, connection: Connection, job: int) -> None:
        """Take a job out of the line; if it runs, its worker is told to abort it."""
        self._app.job_manager.cancel_job_by_id(job, abort=True, connection=_raw(connection))

    def tell(self, connection: Connection, fit_id: str) -> None:
        """Tell everybody that a fit has ended."""
        connection.execute(text("SELECT pg_notify(:channel, :fit)"), {"channel": ENDED, "fit": fit_id})

    def in_line(self, connection: Connection, jobs: Iterable[int]) -> set[int]:
        """Return those of the jobs that nobody has taken yet, and that are due."""
        query = text(
            "SELECT id FROM procrastinate_jobs WHERE id = ANY(:jobs) AND status = 'todo'"
            " AND (scheduled_at IS NULL OR scheduled_at < clock_timestamp() + make_interval(secs => :ahead))"
        )
        return set(connection.execute(query, {"jobs": list(jobs), "ahead": AHEAD}).scalars())


def make(connection: Connection) -> None:
    """Make Procrastinate's tables."""
    connection.exec_driver_sql(SchemaManager.get_schema().replace("%", "%%"))


def steps() -> dict[str, str]:
    """Return the name and the SQL of each step between the versions of Procrastinate's tables, the oldest first."""
    files = sorted(Path(SchemaManager.get_migrations_path()).glob("*.sql"))
    return {file.stem: file.read_text(encoding="utf-8") for file in files}


def _raw(connection: Connection) -> Any:  # noqa: ANN401 - psycopg's, which Procrastinate takes as Any
    """Return the driver's connection under SQLAlchemy's, in the same transaction."""
    return connection.connection.driver_connection
