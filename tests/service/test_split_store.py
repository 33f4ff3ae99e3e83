"""Fits in parts in the store, on SQLite and on PostgreSQL: each part counts once, and transactions never deadlock."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from sqlalchemy import Engine, text

from service.jobs.fit import MAX_ABANDONED, Failure, Fit, FitStatus
from service.jobs.lease_holder import LeaseHolder
from service.jobs.parts import split
from service.jobs.slices import Frame, Slice
from service.store.fits import SqlFits
from tests.service.stores import LIMIT, ME, OTHER, fit, jobs, start

FRAME = Frame((0.1, 1.0 / 3.0, -1e-17), 0.7000000000000001)
PARTS = ["one-00000", "one-00001", "one-00002"]
WHY = Failure("fit-error", "why")


def add_split(store: SqlFits, name: str = "one", most: int = 40) -> Fit:
    whole, parts = split(fit(name, cost=3.0), FRAME, most)
    return store.add(whole, list, parts)[0]


def now(store: SqlFits, name: str = "one") -> Fit:
    found = store.get(name)
    assert found is not None
    return found


def end(store: SqlFits, part: str, attempt: int = 1, result: bytes = b"sums") -> bool:
    return store.finish(part, attempt, FitStatus.SUCCESSFUL, result, None)


def names(store: SqlFits) -> list[str]:
    return [one.id for one in store.waiting()]


def test_the_parts_are_in_line_and_the_fit_is_not_until_the_last_has_ended(store: SqlFits) -> None:
    assert add_split(store).unsummed == 3
    assert names(store) == PARTS
    assert now(store, PARTS[1]).slice == Slice(33, 66, FRAME)  # to the last bit
    assert start(store, "one", ME) is None
    assert [start(store, part, ME) for part in PARTS] == [1, 1, 1]
    assert now(store).status is FitStatus.RUNNING
    for i in (2, 0, 1):
        assert start(store, "one", ME) is None
        assert end(store, PARTS[i], result=f"sums {i}".encode())
    assert (now(store).status, now(store).unsummed, names(store)) == (FitStatus.ACCEPTED, 0, ["one"])
    assert start(store, "one", ME) == 1
    assert store.sums("one") == [b"sums 0", b"sums 1", b"sums 2"]
    assert end(store, "one", result=b"{}")
    assert [store.get(part) for part in PARTS] == [None] * 3
    assert (now(store).result, now(store).input.size) == (b"{}", 1000)


def test_a_part_counts_once_and_only_for_the_attempt_that_holds_it(store: SqlFits) -> None:
    add_split(store)
    start(store, PARTS[0], LeaseHolder("me", 0.0))
    time.sleep(0.01)
    assert start(store, PARTS[0], OTHER) == 2
    assert not end(store, PARTS[0], 1, b"stale")
    assert now(store).unsummed == 3
    assert end(store, PARTS[0], 2, b"fresh")
    assert not end(store, PARTS[0], 2, b"again")
    assert (now(store).unsummed, store.sums("one")) == (2, [b"fresh"])
    assert start(store, PARTS[0], OTHER) is None


def test_of_parts_that_end_at_the_same_time_one_is_the_last(store: SqlFits) -> None:
    add_split(store, most=5)
    parts = names(store)
    assert len(parts) == 20
    with ThreadPoolExecutor(8) as threads:
        assert list(threads.map(lambda part: start(store, part, ME), parts)) == [1] * 20
        assert all(threads.map(lambda part: end(store, part), parts))
    assert names(store) == ["one"]
    with ThreadPoolExecutor(8) as threads:
        started = list(threads.map(lambda _: start(store, "one", ME), range(16)))
    assert [attempt for attempt in started if attempt is not None] == [1]


def test_many_who_start_end_and_dismiss_at_the_same_time_do_not_block_each_other(store: SqlFits) -> None:
    for i in range(6):
        add_split(store, f"{i}", most=10)

    def live(part: str) -> None:
        if attempt := start(store, part, ME):
            end(store, part, attempt)

    with ThreadPoolExecutor(12) as threads:
        began = time.monotonic()
        runs = [threads.submit(live, part) for part in names(store)]
        gone = [threads.submit(store.dismiss, f"{i}") for i in range(3)]
        for run in runs:
            run.result()
        assert all(one.result() for one in gone)
        assert time.monotonic() - began < 10.0
    assert [now(store, f"{i}").status for i in range(3)] == [FitStatus.DISMISSED] * 3
    assert names(store) == ["3", "4", "5"]


ENDS: dict[str, Callable[[SqlFits], bool]] = {
    "dismissed": lambda store: store.dismiss("one"),
    "failed": lambda store: store.finish(PARTS[0], 1, FitStatus.FAILED, None, WHY),
}


@pytest.mark.parametrize("how", ENDS)
def test_with_the_fit_its_parts_go(store: SqlFits, how: str) -> None:
    add_split(store)
    add_split(store, "other")
    for part in PARTS[:2]:
        start(store, part, ME)
    assert ENDS[how](store)
    assert now(store).status == how
    assert now(store).failure == (WHY if how == "failed" else None)
    assert now(store).finished is not None
    assert [store.get(part) for part in PARTS] == [None] * 3
    assert not end(store, PARTS[1])
    assert not store.renew(PARTS[1], 1, 60.0)
    assert len(names(store)) == 3  # those of the other one
    assert store.remove("one", list)


def test_a_part_that_outlives_too_many_supervisors_fails_its_fit(store: SqlFits) -> None:
    add_split(store)
    for attempt in range(1, MAX_ABANDONED + 1):
        assert start(store, PARTS[0], LeaseHolder("me", 0.0)) == attempt
        time.sleep(0.01)
    assert start(store, PARTS[0], ME) is None
    failure = now(store).failure
    assert failure is not None
    assert failure.kind == "worker-crashed"
    assert names(store) == []


def test_recovery_puts_parts_and_rests_back_in_line_and_keeps_what_was_summed(store: SqlFits) -> None:
    add_split(store)
    add_split(store, "two", most=100)  # of one part
    for part in (*PARTS[:2], "two-00000"):
        start(store, part, ME)
    end(store, PARTS[0])
    end(store, "two-00000")
    start(store, "two", ME)
    assert store.recover() == 2
    assert names(store) == [*PARTS[1:], "two"]
    assert (now(store).status, now(store).unsummed) == (FitStatus.RUNNING, 2)
    assert start(store, PARTS[1], ME) == 2


def test_however_many_parts_wait_they_are_one_fit_to_the_queue(store: SqlFits) -> None:
    add_split(store, most=1)
    assert (len(names(store)), store.count_waiting()) == (100, 1)
    for i in range(LIMIT - 1):
        add_split(store, f"{i}")
    assert store.count_waiting() == LIMIT


def test_what_was_summed_is_no_fit_that_ended(store: SqlFits) -> None:
    add_split(store)
    start(store, PARTS[0], ME)
    end(store, PARTS[0])
    time.sleep(0.01)
    assert store.outdated(0.001, 0) == []
    assert not store.remove(PARTS[0], list)
    assert store.unused(["b10b"]) == []


def test_parts_have_jobs_in_the_lane_of_the_long_and_then_the_fit_has_one(
    cluster_store: SqlFits, database: Engine
) -> None:
    add_split(cluster_store)
    assert jobs(database) == ["todo"] * 3
    for part in PARTS:
        start(cluster_store, part, ME)
        end(cluster_store, part)
    with database.connect() as connection:
        query = text("SELECT args->>'fit_id', queue_name FROM procrastinate_jobs ORDER BY id")
        found = [(name, queue) for name, queue in connection.execute(query)]
    assert found == [*((part, "long") for part in PARTS), ("one", "long")]


def test_with_the_fit_the_jobs_of_its_parts_go(cluster_store: SqlFits, database: Engine) -> None:
    add_split(cluster_store)
    start(cluster_store, PARTS[0], ME)
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET status = 'doing' WHERE args->>'fit_id' = 'one-00000'"))
    assert cluster_store.dismiss("one")
    assert sorted(jobs(database)) == ["cancelled", "cancelled", "doing"]
    with database.connect() as connection:
        query = text("SELECT abort_requested FROM procrastinate_jobs WHERE status = 'doing'")
        assert connection.execute(query).scalar_one()


def test_lost_jobs_of_parts_are_replaced_and_a_fit_that_waits_for_parts_needs_none(
    cluster_store: SqlFits, database: Engine
) -> None:
    add_split(cluster_store)
    start(cluster_store, PARTS[0], ME)
    assert cluster_store.requeue_lost(0.0) == 0
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET status = 'failed'"))
        connection.execute(text("UPDATE fits SET touched = now() - interval '1 hour'"))
    assert cluster_store.requeue_lost(60.0) == 2
    assert sorted(jobs(database)) == ["failed"] * 3 + ["todo"] * 2


def test_a_part_is_as_long_as_its_fit() -> None:
    whole = replace(fit("one", cost=0.1))
    assert whole.short
    assert not any(part.short for part in split(whole, FRAME, 40)[1])
