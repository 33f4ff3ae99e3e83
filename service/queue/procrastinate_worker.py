"""A worker process of a cluster: it takes jobs from Procrastinate's queues and runs their fits."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import AsyncExitStack
from datetime import UTC, datetime, timedelta

from procrastinate import App, BaseRetryStrategy, JobContext, PsycopgConnector, RetryDecision
from procrastinate.jobs import DeleteJobCondition, Job, Status

from service.jobs.store_ports import FitStore
from service.queue.procrastinate_jobs import LONG_QUEUE, SHORT_QUEUE, TASK
from service.queue.runner import RELEASE_SECONDS, Runner, pause

logger = logging.getLogger(__name__)

UPKEEP_QUEUE = "upkeep"
UPKEEP = "*/1 * * * * */5"  # every five seconds: the sixth field is that of the seconds
# Seconds before a lane that lost the database tries again.
RECONNECT_SECONDS = 1.0
# Seconds that a lane waits for a connection to the database before it fails.
CONNECTION_TIMEOUT = 60.0
# Seconds between two looks for new and for aborted jobs. Both are notified at once; notifications may be lost.
POLL_SECONDS = 2.0
# A time that is in the past on every machine, however its clock is set.
AT_ONCE = datetime(2000, 1, 1, tzinfo=UTC)
# Hours after which failed, cancelled and aborted jobs are deleted. How their fits ended is stored with the fits.
DELETE_AFTER_HOURS = 1


class _Interrupted(Exception):  # noqa: N818 - no error
    """The process is about to end, and the fit was released."""


class _HeldElsewhere(Exception):  # noqa: N818 - no error
    """Another process holds the lease of the fit, or a dead process whose lease has not run out yet."""


class _RetryUntilEnded(BaseRetryStrategy):
    """Schedules a job again until its fit has ended."""

    def __init__(self, lease: float) -> None:
        self._lease = lease

    def get_retry_decision(self, *, exception: BaseException, job: Job) -> RetryDecision:
        """Return when the job runs again: at once, after the lease, or after a pause that grows with each try."""
        if isinstance(exception, _Interrupted):
            return RetryDecision(retry_at=AT_ONCE)
        seconds = self._lease if isinstance(exception, _HeldElsewhere) else pause(job.attempts + 1)
        return RetryDecision(retry_at=datetime.now(UTC) + timedelta(seconds=seconds))


class ProcrastinateWorker:
    """Runs a fixed number of fits of the database's queues at once; some of its seats take short fits only."""

    def __init__(  # noqa: PLR0913 - three collaborators, four settings
        self,
        store: FitStore,
        runner: Runner,
        clean_up: Callable[[], bool],
        *,
        url: str,
        seats: int,
        short_seats: int,
        lease: float,
    ) -> None:
        """Work for the database at `url`; one process of all calls `clean_up` every few seconds, until it is done."""
        self._store, self._runner, self._clean_up, self._lease = store, runner, clean_up, lease
        self._lanes = [((SHORT_QUEUE, LONG_QUEUE), seats), ((SHORT_QUEUE,), short_seats), ((UPKEEP_QUEUE,), 1)]
        self._app = App(connector=PsycopgConnector(conninfo=url, min_size=1, max_size=8, timeout=CONNECTION_TIMEOUT))
        self._app.task(name=TASK, pass_context=True, retry=_RetryUntilEnded(lease))(self._fit)
        upkeep = self._app.task(name="upkeep", queue=UPKEEP_QUEUE, queueing_lock="upkeep", pass_context=True)
        self._app.periodic(cron=UPKEEP)(upkeep(self._upkeep))
        self._runs: set[asyncio.Task[bool]] = set()
        self._stopped, self._drain_ended = asyncio.Event(), asyncio.Event()

    @property
    def stopping(self) -> bool:
        """Return whether `stop` was called."""
        return self._stopped.is_set()

    def stop(self) -> None:
        """Take no more jobs and let the running ones end; when called again, end at once."""
        if self._stopped.is_set():
            self._drain_ended.set()
        self._stopped.set()

    async def work(self, grace: float) -> None:
        """Work until `stop` is called; then give running fits `grace` seconds to end, and release the others."""
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self._app.open_async())
            lanes = [asyncio.create_task(self._lane(queues, seats)) for queues, seats in self._lanes if seats]
            await self._stopped.wait()
            for lane in lanes:
                lane.cancel()  # Procrastinate then fetches no more jobs, and ends when its running jobs have ended
            end = asyncio.create_task(self._drain_ended.wait())
            if self._runs:
                every = asyncio.gather(*self._runs, return_exceptions=True)
                await asyncio.wait((every, end), timeout=grace, return_when=asyncio.FIRST_COMPLETED)
            end.cancel()
            for run in list(self._runs):
                run.cancel()
            await asyncio.wait(lanes, timeout=2.0 * RELEASE_SECONDS)

    async def _lane(self, queues: tuple[str, ...], seats: int) -> None:
        """Run one of Procrastinate's workers, and a new one when it failed because the database was away too long."""
        while True:
            try:
                await self._app.run_worker_async(
                    queues=list(queues),
                    concurrency=seats,
                    install_signal_handlers=False,
                    fetch_job_polling_interval=POLL_SECONDS,
                    abort_job_polling_interval=POLL_SECONDS,
                    update_heartbeat_interval=self._lease / 3.0,
                    stalled_worker_timeout=self._lease,
                    delete_jobs=DeleteJobCondition.SUCCESSFUL,
                )
            except Exception:  # without a new one the seats of this lane would stay empty unnoticed
                logger.exception("the lane %s lost its database", "+".join(queues))
            await asyncio.sleep(RECONNECT_SECONDS)

    async def _fit(self, context: JobContext, fit_id: str) -> None:
        """Run a fit as a job; raise if the job has to run again."""
        short = LONG_QUEUE not in (context.worker_queues or ())
        run = asyncio.create_task(self._runner.run(fit_id, short=short), name=f"fit {fit_id}")
        self._runs.add(run)
        run.add_done_callback(self._runs.discard)
        try:
            if await run:
                return
        except asyncio.CancelledError:
            this = asyncio.current_task()
            if this is not None and this.cancelling():  # Procrastinate cancels the job: its fit was dismissed
                raise
            raise _Interrupted from None
        fit = await asyncio.to_thread(self._store.get, fit_id)
        if fit is not None and not fit.status.final:
            raise _HeldElsewhere

    async def _upkeep(self, context: JobContext, timestamp: int) -> None:  # noqa: ARG002 - Procrastinate passes it
        """Queue the jobs of dead workers again, delete old jobs, and clean up the store."""
        manager = context.app.job_manager
        for job in await manager.get_stalled_jobs(seconds_since_heartbeat=self._lease):
            if job.task_name != TASK:  # the periodic upkeep job is scheduled anew in any case
                await manager.finish_job(job, Status.FAILED, delete_job=True)
                continue
            logger.warning("job %s is queued again: its worker is dead", job.id)
            await manager.retry_job(job, AT_ONCE)
        await manager.delete_old_jobs(
            nb_hours=DELETE_AFTER_HOURS, include_failed=True, include_cancelled=True, include_aborted=True
        )
        while await asyncio.to_thread(self._clean_up) and not self.stopping:
            pass
