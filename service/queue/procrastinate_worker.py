"""The workers of a cluster: Procrastinate brings the fits, and this runs them."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import AsyncExitStack
from datetime import UTC, datetime, timedelta

from procrastinate import App, BaseRetryStrategy, JobContext, PsycopgConnector, RetryDecision
from procrastinate.jobs import DeleteJobCondition, Job, Status

from service.jobs.ports import FitStore
from service.queue.procrastinate_jobs import LONG_QUEUE, SHORT_QUEUE, TASK
from service.queue.runner import PARTING, Runner, pause

logger = logging.getLogger(__name__)

UPKEEP_QUEUE = "upkeep"
UPKEEP = "*/1 * * * * */5"  # every five seconds: the sixth field is that of the seconds
# Seconds before a lane that lost its database tries again.
PAUSE = 1.0
# Seconds that a database may be away before the lanes notice.
PATIENCE = 60.0
# Seconds between looks for jobs and for aborts; both are told at once, so this is for words that were lost.
POLL = 2.0
# A time that is over on every machine, however its clock is set.
AT_ONCE = datetime(2000, 1, 1, tzinfo=UTC)
# Hours after which jobs that ended otherwise than well are forgotten; what came of their fits stands in the fits.
FORGET = 1


class _Interrupted(Exception):  # noqa: N818 - no error
    """The process is about to end; the fit was given back."""


class _Held(Exception):  # noqa: N818 - no error
    """Somebody else holds the fit, or did when it died."""


class _Again(BaseRetryStrategy):
    """Brings a job back until its fit has ended."""

    def __init__(self, lease: float) -> None:
        self._lease = lease

    def get_retry_decision(self, *, exception: BaseException, job: Job) -> RetryDecision:
        if isinstance(exception, _Interrupted):
            return RetryDecision(retry_at=AT_ONCE)
        seconds = self._lease if isinstance(exception, _Held) else pause(job.attempts + 1)
        return RetryDecision(retry_at=datetime.now(UTC) + timedelta(seconds=seconds))


class ProcrastinateWorker:
    """Runs fits from the database's queues, in so many seats, some of them for short fits only."""

    def __init__(  # noqa: PLR0913 - three parts, four facts
        self,
        store: FitStore,
        runner: Runner,
        tidy: Callable[[], object],
        *,
        url: str,
        seats: int,
        short_seats: int,
        lease: float,
    ) -> None:
        """Work for the database at `url`; `tidy` is called now and then, in one process of all."""
        self._store, self._runner, self._tidy, self._lease = store, runner, tidy, lease
        self._lanes = [((SHORT_QUEUE, LONG_QUEUE), seats), ((SHORT_QUEUE,), short_seats), ((UPKEEP_QUEUE,), 1)]
        self._app = App(connector=PsycopgConnector(conninfo=url, min_size=1, max_size=8, timeout=PATIENCE))
        self._app.task(name=TASK, pass_context=False, retry=_Again(lease))(self._fit)
        upkeep = self._app.task(name="upkeep", queue=UPKEEP_QUEUE, queueing_lock="upkeep", pass_context=True)
        self._app.periodic(cron=UPKEEP)(upkeep(self._upkeep))
        self._runs: set[asyncio.Task[None]] = set()
        self._stopped, self._hurried = asyncio.Event(), asyncio.Event()

    def stop(self) -> None:
        """Take nothing more; called again, end at once."""
        if self._stopped.is_set():
            self._hurried.set()
        self._stopped.set()

    async def work(self, grace: float) -> None:
        """Work until told to stop, then give what runs so many seconds to end, and give the rest back."""
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self._app.open_async())
            lanes = [asyncio.create_task(self._lane(queues, seats)) for queues, seats in self._lanes if seats]
            await self._stopped.wait()
            for lane in lanes:
                lane.cancel()  # which has Procrastinate fetch no more, and end when its jobs have
            hurried = asyncio.create_task(self._hurried.wait())
            if self._runs:
                every = asyncio.gather(*self._runs, return_exceptions=True)
                await asyncio.wait((every, hurried), timeout=grace, return_when=asyncio.FIRST_COMPLETED)
            hurried.cancel()
            for run in list(self._runs):
                run.cancel()
            await asyncio.wait(lanes, timeout=2.0 * PARTING)

    async def _lane(self, queues: tuple[str, ...], seats: int) -> None:
        """Run one of Procrastinate's workers, and another when the database was away for too long for it."""
        while True:
            try:
                await self._app.run_worker_async(
                    queues=list(queues),
                    concurrency=seats,
                    install_signal_handlers=False,
                    fetch_job_polling_interval=POLL,
                    abort_job_polling_interval=POLL,
                    update_heartbeat_interval=self._lease / 3.0,
                    stalled_worker_timeout=self._lease,
                    delete_jobs=DeleteJobCondition.SUCCESSFUL,
                )
            except Exception:  # a lane that ended would leave its seats empty, and nobody would see
                logger.exception("the lane %s lost its database", "+".join(queues))
            await asyncio.sleep(PAUSE)

    async def _fit(self, fit_id: str) -> None:
        """Run a fit as a job; raise if the job must come again."""
        run = asyncio.create_task(self._runner.run(fit_id), name=f"fit {fit_id}")
        self._runs.add(run)
        run.add_done_callback(self._runs.discard)
        try:
            await run
        except asyncio.CancelledError:
            this = asyncio.current_task()
            if this is not None and this.cancelling():  # Procrastinate cancels the job: its fit was dismissed
                raise
            raise _Interrupted from None
        fit = await asyncio.to_thread(self._store.get, fit_id)
        if fit is not None and not fit.status.final:
            raise _Held

    async def _upkeep(self, context: JobContext, timestamp: int) -> None:  # noqa: ARG002 - what periodic tasks get
        """Bring back the jobs of dead workers, and have the store tidied."""
        manager = context.app.job_manager
        for job in await manager.get_stalled_jobs(seconds_since_heartbeat=self._lease):
            if job.task_name != TASK:  # upkeep comes again by itself
                await manager.finish_job(job, Status.FAILED, delete_job=True)
                continue
            logger.warning("job %s was left by a worker that is dead, and is queued again", job.id)
            await manager.retry_job(job, AT_ONCE)
        await manager.delete_old_jobs(
            nb_hours=FORGET, include_failed=True, include_cancelled=True, include_aborted=True
        )
        await asyncio.to_thread(self._tidy)
