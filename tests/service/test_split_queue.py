"""Fits in parts in the embedded queue, with a real store and real workers."""

import asyncio
from pathlib import Path

from service.jobs.fit import FitStatus
from tests.service.queues import LONG, Bench, run

ANSWER = b"0-3 3-6 6-9"


def test_the_parts_run_and_then_the_rest(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit_split("one", {"parts": {"seconds": 0.1}})
        await b.until("one", FitStatus.RUNNING)
        one = await b.ended("one")
        assert (one.status, one.result, one.attempt) == (FitStatus.SUCCESSFUL, ANSWER, 1)
        assert b.rows() == 1

    run(tmp_path, script)


def test_a_part_whose_worker_dies_once_runs_again_and_twice_fails_the_fit(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit_split("unlucky", {"3": {"once": str(tmp_path / "once")}})
        b.submit_split("deadly", {"3": {"die": True}})
        b.submit("next")
        unlucky, deadly, after = [await b.ended(name) for name in ("unlucky", "deadly", "next")]
        assert (unlucky.status, unlucky.result) == (FitStatus.SUCCESSFUL, ANSWER)
        assert deadly.failure is not None
        assert (deadly.failure.kind, deadly.attempt) == ("worker-crashed", 0)
        assert after.status is FitStatus.SUCCESSFUL
        assert b.rows() == 3

    run(tmp_path, script)


def test_a_part_that_fails_fails_the_fit_and_ends_the_other_parts(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit_split("one", {"0": {"fail": True}, "3": {"seconds": 30.0}, "6": {"seconds": 30.0}})
        b.submit_split("slow", {"parts": {"seconds": 30.0}})
        b.submit("next")
        one, slow, after = [await b.ended(name) for name in ("one", "slow", "next")]
        assert one.failure is not None
        assert (one.failure.kind, one.failure.detail) == ("fit-error", "ValueError: as told")
        assert slow.failure is not None
        assert slow.failure.kind == "deadline-exceeded"
        assert after.status is FitStatus.SUCCESSFUL
        assert b.rows() == 3

    run(tmp_path, script)


def test_what_is_left_of_a_fit_crashes_and_fails_as_any_fit(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit_split("unlucky", {"once": str(tmp_path / "once")})
        b.submit_split("deadly", {"die": True})
        unlucky, deadly = [await b.ended(name) for name in ("unlucky", "deadly")]
        assert (unlucky.status, unlucky.result, unlucky.attempt) == (FitStatus.SUCCESSFUL, ANSWER, 2)
        assert deadly.failure is not None
        assert (deadly.failure.kind, deadly.attempt) == ("worker-crashed", 2)
        assert b.rows() == 2

    run(tmp_path, script)


def test_dismissed_it_is_rid_of_all_its_parts(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit_split("one", {"parts": {"seconds": 30.0}})
        waiting = asyncio.create_task(b.queue.wait("one", 20.0))
        await b.until("one", FitStatus.RUNNING)
        assert b.store.dismiss("one")
        b.queue.cancel("one")
        await asyncio.wait_for(waiting, 0.5)
        b.submit("next")
        assert (await b.ended("next")).status is FitStatus.SUCCESSFUL
        assert b.now("one").status is FitStatus.DISMISSED
        assert b.rows() == 2

    run(tmp_path, script)


def test_a_closed_queue_leaves_parts_and_rest_to_the_next(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit_split("one", {"3": {"seconds": 0.5}, "6": {"seconds": 0.5}, "seconds": 0.5})
        for summed in (1, 3):  # between two parts; between the last part and the rest, or in the rest
            while b.now("one").parts - b.now("one").unsummed < summed:  # noqa: ASYNC110 - the store tells nobody
                await asyncio.sleep(0.01)
            await b.queue.close()
            b.queue = b.anew()
            await b.queue.resume()
            waiting = asyncio.create_task(b.queue.wait("one", 20.0))
        await waiting
        assert b.now("one").result == ANSWER
        assert b.rows() == 1

    run(tmp_path, script)


def test_short_fits_do_not_wait_for_the_parts_of_a_huge_one(tmp_path: Path) -> None:
    async def script(b: Bench) -> None:
        b.submit_split("huge", {"parts": {"seconds": 0.5}}, cost=0.3)  # each of which is short, but not all of them
        b.submit("short", cost=0.1)
        assert (await b.ended("short")).status is FitStatus.SUCCESSFUL
        assert b.now("huge").unsummed == 3
        assert b.now("huge").cost < LONG

    run(tmp_path, script)
