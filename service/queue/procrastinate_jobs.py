"""The queue in PostgreSQL: Procrastinate's jobs, changed in the same transactions as the fits."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from procrastinate import App, SyncPsycopgConnector
from procrastinate.schema import SchemaManager
from sqlalchemy import Connection, text

TASK = "fit"
SHORT_QUEUE, LONG_QUEUE = "short", "long"
# Seconds after which a job that is to be tried again is due at the latest. If it is scheduled for later than that, the
# clock of the machine that scheduled it was wrong.
LATEST_RETRY_SECONDS = 120.0
# The channel of PostgreSQL's NOTIFY with the ids of fits that have ended.
ENDED_CHANNEL = "ipfit_ended"


class ProcrastinateJobs:
    """Adds jobs of fits to Procrastinate's queues and cancels them, on the connection of the caller's transaction."""

    def __init__(self) -> None:
        """Open no connection: the methods use that of their caller."""
        self._app = App(connector=SyncPsycopgConnector())

    def enqueue(self, connection: Connection, fit_id: str, place: int, *, short: bool) -> int:
        """Add a job for a fit to the queue of short or of long fits, and return its number. Low places are first."""
        queue = SHORT_QUEUE if short else LONG_QUEUE
        deferrer = self._app.configure_task(TASK, queue=queue, priority=-place, connection=_raw(connection))
        return deferrer.defer(fit_id=fit_id)

    def move_to_short(self, connection: Connection, job: int) -> bool:
        """Move a job that no worker has taken yet to the queue of short fits; return whether it was moved."""
        query = text("UPDATE procrastinate_jobs SET queue_name = :short WHERE id = :job AND status = 'todo'")
        return bool(connection.execute(query, {"short": SHORT_QUEUE, "job": job}).rowcount)

    def cancel(self, connection: Connection, job: int) -> None:
        """Cancel a job; if it runs, its worker is told to abort it."""
        self._app.job_manager.cancel_job_by_id(job, abort=True, connection=_raw(connection))

    def notify_ended(self, connection: Connection, fit_id: str) -> None:
        """Notify all API processes that a fit has ended."""
        connection.execute(text("SELECT pg_notify(:channel, :fit)"), {"channel": ENDED_CHANNEL, "fit": fit_id})

    def queued(self, connection: Connection, jobs: Iterable[int]) -> set[int]:
        """Return those of the jobs that no worker has taken yet, and that are due soon."""
        query = text(
            "SELECT id FROM procrastinate_jobs WHERE id = ANY(:jobs) AND status = 'todo'"
            " AND (scheduled_at IS NULL OR scheduled_at < clock_timestamp() + make_interval(secs => :ahead))"
        )
        return set(connection.execute(query, {"jobs": list(jobs), "ahead": LATEST_RETRY_SECONDS}).scalars())


def make(connection: Connection) -> None:
    """Make Procrastinate's tables."""
    connection.exec_driver_sql(SchemaManager.get_schema().replace("%", "%%"))


def steps() -> dict[str, str]:
    """Return the SQL of each migration of Procrastinate's tables by its name, the oldest first."""
    files = sorted(Path(SchemaManager.get_migrations_path()).glob("*.sql"))
    return {file.stem: file.read_text(encoding="utf-8") for file in files}


def _raw(connection: Connection) -> Any:  # noqa: ANN401 - psycopg's, which Procrastinate takes as Any
    """Return the driver's connection under SQLAlchemy's, in the same transaction."""
    return connection.connection.driver_connection
