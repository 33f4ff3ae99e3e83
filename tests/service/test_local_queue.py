"""The embedded queue with a real store, real blobs and real workers, whose tasks do what their input says."""

import asyncio
import time
from pathlib import Path

from sqlalchemy import text

from service.jobs.fit import Fit, FitStatus
from service.jobs.lease_holder import LeaseHolder
from service.queue.runner import MAX_AWAY
from tests.service.queues import Bench, run
from tests.service.running import until
from tests.service.stores import start


def test_fits_are_run_and_end_as_they_should(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("good")
        b.submit("bad", fail=True)
        b.submit("deadly", die=True)
        b.submit("unlucky", once=str(tmp_path / "once"))
        b.submit("slow", seconds=30.0)
        b.submit("greedy", greedy=True)
        b.submit("last")
        good, bad, deadly, unlucky, slow, greedy, last = [
            await b.ended(name) for name in ("good", "bad", "deadly", "unlucky", "slow", "greedy", "last")
        ]
        assert (good.status, good.result, good.attempt) == (FitStatus.SUCCESSFUL, b"answer", 1)
        assert bad.failure is not None
        assert (bad.failure.kind, bad.failure.detail) == ("fit-error", "ValueError: as told")
        assert deadly.failure is not None
        assert (deadly.failure.kind, deadly.attempt, deadly.crashes) == ("worker-crashed", 2, 1)
        assert greedy.failure is not None
        assert (greedy.failure.kind, greedy.attempt) == ("out-of-memory", 1)
        assert (unlucky.status, unlucky.attempt) == (FitStatus.SUCCESSFUL, 2)
        assert slow.failure is not None
        assert (slow.failure.kind, slow.attempt) == ("deadline-exceeded", 1)
        assert last.status is FitStatus.SUCCESSFUL

    run(tmp_path, script)


def test_progress_is_there_while_a_fit_runs_and_not_after(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.5)
        await b.until("one", FitStatus.RUNNING)
        await asyncio.sleep(0.3)
        assert await b.queue.progress("one") == [{"degree": 3}]
        await b.ended("one")
        assert await b.queue.progress("one") == []

    run(tmp_path, script)


def test_the_work_begins_while_the_start_is_being_stored(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        store_start, loop = b.store.start, asyncio.get_running_loop()

        def start_when_begun(fit_id: str, holder: LeaseHolder) -> Fit | None:
            until(lambda: asyncio.run_coroutine_threadsafe(b.queue.progress(fit_id), loop).result(), 10.0)
            return store_start(fit_id, holder)

        b.store.start = start_when_begun  # type: ignore[method-assign] # the real one, but later
        b.submit("one", seconds=0.2)
        assert (await b.ended("one")).result == b"answer"

    run(tmp_path, script)


def test_work_that_began_for_a_fit_which_does_not_start_is_killed(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        store_start, loop = b.store.start, asyncio.get_running_loop()

        def dismiss_when_begun(fit_id: str, holder: LeaseHolder) -> Fit | None:
            if fit_id == "one":
                until(lambda: asyncio.run_coroutine_threadsafe(b.queue.progress(fit_id), loop).result(), 10.0)
                b.store.dismiss(fit_id)
            return store_start(fit_id, holder)

        b.store.start = dismiss_when_begun  # type: ignore[method-assign] # as above
        b.submit("one", seconds=60.0)
        assert (await b.ended("one")).status is FitStatus.DISMISSED
        assert await b.queue.progress("one") == []
        assert b.workers.busy == 0
        b.submit("two")
        assert (await b.ended("two")).status is FitStatus.SUCCESSFUL

    run(tmp_path, script)


def test_a_dismissed_fit_stays_dismissed_and_the_next_one_runs(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        for name in ("running", "waiting", "next"):
            b.submit(name, seconds=0.0 if name == "next" else 30.0)
        await b.until("running", FitStatus.RUNNING)
        for name in ("running", "waiting"):
            assert b.store.dismiss(name)
            b.queue.cancel(name)
        assert (await b.ended("next")).status is FitStatus.SUCCESSFUL
        assert [b.now(name).status for name in ("running", "waiting")] == [FitStatus.DISMISSED] * 2

    run(tmp_path, script)


def test_a_closed_queue_leaves_its_fits_to_the_next(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("running", seconds=0.8)
        b.submit("waiting")
        await b.until("running", FitStatus.RUNNING)
        await b.queue.close()
        assert [fit.id for fit in b.store.waiting()] == ["running", "waiting"]
        b.queue = b.anew()
        await b.queue.resume()
        assert [(await b.ended(name)).status for name in ("running", "waiting")] == [FitStatus.SUCCESSFUL] * 2

    run(tmp_path, script)


def test_those_who_wait_are_let_go_when_the_server_stops(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.8)
        waiting = asyncio.create_task(b.queue.wait("one", 20.0))
        await b.until("one", FitStatus.RUNNING)
        await asyncio.wait_for(b.queue.drain(0.1), 0.3)
        await asyncio.wait_for(waiting, 0.1)
        assert b.queue.stopping
        assert b.now("one").status is FitStatus.RUNNING

    run(tmp_path, script)


def test_nobody_waits_longer_than_asked(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.8)
        began = time.monotonic()
        await b.queue.wait("one", 0.1)
        await b.queue.wait("unknown", 20.0)
        assert time.monotonic() - began < 0.5

    run(tmp_path, script)


def test_an_answer_outlives_a_store_that_fails_for_a_while(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.4)
        await b.until("one", FitStatus.RUNNING)
        with b.engine.begin() as connection:
            connection.execute(text("ALTER TABLE fits RENAME TO elsewhere"))
        await asyncio.sleep(0.8)
        with b.engine.begin() as connection:
            connection.execute(text("ALTER TABLE elsewhere RENAME TO fits"))
        ended = await b.ended("one")
        assert (ended.status, ended.result, ended.attempt) == (FitStatus.SUCCESSFUL, b"answer", 1)

    run(tmp_path, script)


def test_a_drain_lets_what_runs_end_and_starts_nothing(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("running", seconds=0.5)
        b.submit("waiting")
        await b.until("running", FitStatus.RUNNING)
        await b.queue.drain(10.0)
        assert b.now("running").status is FitStatus.SUCCESSFUL
        assert b.now("waiting").status is FitStatus.ACCEPTED

    run(tmp_path, script)


def test_a_drain_that_is_hurried_ends_at_once(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("running", seconds=30.0)
        await b.until("running", FitStatus.RUNNING)
        draining = asyncio.create_task(b.queue.drain(60.0))
        await asyncio.sleep(0.1)
        assert not draining.done()
        b.queue.end_drain()
        await asyncio.wait_for(draining, 0.5)
        await b.queue.close()
        assert (b.now("running").status, b.now("running").attempt) == (FitStatus.ACCEPTED, 1)

    run(tmp_path, script)


def test_a_queue_closes_in_seconds_though_its_store_fails(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=30.0)
        await b.until("one", FitStatus.RUNNING)
        with b.engine.begin() as connection:
            connection.execute(text("ALTER TABLE fits RENAME TO elsewhere"))
        await asyncio.wait_for(b.queue.close(), 5.0)
        with b.engine.begin() as connection:
            connection.execute(text("ALTER TABLE elsewhere RENAME TO fits"))
        b.queue = b.anew()
        await b.queue.resume()
        b.queue.cancel("one")

    run(tmp_path, script)


def test_a_short_fit_overtakes_long_ones(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        for name in ("long", "longer"):
            b.submit(name, seconds=0.7)
        b.submit("short", cost=0.1)
        assert (await b.ended("short")).status is FitStatus.SUCCESSFUL
        assert b.now("long").status is FitStatus.RUNNING
        assert b.now("longer").status is FitStatus.ACCEPTED

    run(tmp_path, script)


def test_a_client_with_one_fit_does_not_wait_for_all_of_another(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        for i in range(6):
            b.submit(f"many {i}", client="many", seconds=0.1)
        b.submit("one", client="one")
        one = await b.ended("one")
        last = await b.ended("many 5")
        before = [i for i in range(6) if (b.now(f"many {i}").started or one.created) < (one.started or one.created)]
        assert before == [0]
        assert last.status is FitStatus.SUCCESSFUL

    run(tmp_path, script)


def test_a_fit_whose_lease_was_lost_is_given_up_and_taken_over_when_the_other_is_heard_of_no_more(
    tmp_path: Path,
) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", seconds=0.8)
        b.submit("next")
        await b.until("one", FitStatus.RUNNING)
        b.store.recover()  # as if somebody else had taken it for dead
        assert start(b.store, "one", LeaseHolder("other", 2.0)) == 2
        assert (await b.ended("next")).status is FitStatus.SUCCESSFUL
        one = await b.ended("one")
        assert (one.status.final, one.attempt) == (True, 3)  # a worker that must first start may be over its deadline

    run(tmp_path, script)


def test_a_fit_whose_points_cannot_be_read_is_tried_again_and_lets_others_run(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit("one", away=str(tmp_path / "there"))
        b.submit("gone", away=str(tmp_path / "never"))
        b.submit("next")
        assert (await b.ended("next")).status is FitStatus.SUCCESSFUL
        await b.until("one", FitStatus.ACCEPTED)
        (tmp_path / "there").touch()
        one = await b.ended("one")
        assert one.status is FitStatus.SUCCESSFUL
        assert one.attempt > 1
        assert one.crashes == 0
        assert b.store.dismiss("gone")
        b.queue.cancel("gone")
        assert (await b.ended("gone")).status is FitStatus.DISMISSED

    run(tmp_path, script)


def test_a_fit_whose_points_stay_away_fails_in_the_end(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        fit = b.new_fit("one", {"away": "/"})
        b.store.add(fit, list)
        for attempt in range(1, MAX_AWAY):
            assert start(b.store, "one", LeaseHolder("me", 60.0)) == attempt
            assert b.store.release("one", attempt)
        b.queue.submit(fit)
        failure = (await b.ended("one")).failure
        assert failure is not None
        assert failure.kind == "fit-error"
        assert "cannot be read" in failure.detail

    run(tmp_path, script)
