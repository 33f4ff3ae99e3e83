"""The fit store on SQLite and on PostgreSQL: it is durable, and allows legal transitions only."""

import dataclasses
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path

import pytest
from procrastinate.exceptions import ConnectorException
from sqlalchemy import Engine, text

from service.jobs.errors import KeyReusedError, QueueFullError
from service.jobs.fit import MAX_ABANDONED, TRANSITIONS, Failure, FitStatus
from service.jobs.lease_holder import LeaseHolder
from service.queue.procrastinate_jobs import ProcrastinateJobs
from service.store.fits import SqlFits
from service.store.schema import sqlite_engine
from tests.service.stores import LIMIT, ME, NOW, OTHER, add, fit, jobs


def bring(store: SqlFits, status: FitStatus) -> None:
    """Add a fit and bring it to this status."""
    add(store, fit())
    if status is FitStatus.DISMISSED:
        store.dismiss("one")
    elif status is not FitStatus.ACCEPTED:
        store.start("one", ME)
    if status in (FitStatus.SUCCESSFUL, FitStatus.FAILED):
        store.finish("one", 1, status, None, None)


def test_what_was_added_comes_back(store: SqlFits) -> None:
    add(store, fit())
    assert store.get("one") == fit()
    assert store.get("two") is None


def test_a_successful_life(store: SqlFits) -> None:
    add(store, fit())
    assert store.start("one", ME) == 1
    assert store.finish("one", 1, FitStatus.SUCCESSFUL, b"{}", None)
    found = store.get("one")
    assert found is not None
    assert found.started is not None
    assert found.finished is not None
    assert NOW < found.started <= found.finished
    assert dataclasses.replace(found, started=None, finished=None) == dataclasses.replace(
        fit(), status=FitStatus.SUCCESSFUL, attempt=1, result=b"{}"
    )


def test_a_failure_comes_back(store: SqlFits) -> None:
    bring(store, FitStatus.RUNNING)
    assert store.finish("one", 1, FitStatus.FAILED, None, Failure("fit-error", "why"))
    found = store.get("one")
    assert found is not None
    assert found.failure == Failure("fit-error", "why")


ACTIONS: list[tuple[FitStatus, Callable[[SqlFits], object]]] = [
    (FitStatus.RUNNING, lambda store: store.start("one", ME)),
    (FitStatus.ACCEPTED, lambda store: store.release("one", 1)),
    (FitStatus.SUCCESSFUL, lambda store: store.finish("one", 1, FitStatus.SUCCESSFUL, b"{}", None)),
    (FitStatus.FAILED, lambda store: store.finish("one", 1, FitStatus.FAILED, None, Failure("a", "b"))),
    (FitStatus.DISMISSED, lambda store: store.dismiss("one")),
]


@pytest.mark.parametrize("status", list(FitStatus))
@pytest.mark.parametrize(("target", "action"), ACTIONS, ids=[str(target) for target, _ in ACTIONS])
def test_every_move_is_made_if_legal_and_changes_nothing_if_not(
    store: SqlFits, status: FitStatus, target: FitStatus, action: Callable[[SqlFits], object]
) -> None:
    bring(store, status)
    before = store.get("one")
    legal = target in TRANSITIONS[status]
    assert bool(action(store)) is legal
    after = store.get("one")
    assert after is not None
    assert after.status is (target if legal else status)
    assert legal or after == before


def test_only_the_attempt_that_holds_a_fit_may_end_it(store: SqlFits) -> None:
    bring(store, FitStatus.RUNNING)
    assert store.release("one", 1)
    assert store.start("one", ME) == 2
    assert not store.finish("one", 1, FitStatus.SUCCESSFUL, b"stale", None)
    assert not store.release("one", 1)
    assert store.finish("one", 2, FitStatus.SUCCESSFUL, b"fresh", None)
    found = store.get("one")
    assert found is not None
    assert found.result == b"fresh"


def test_of_many_who_start_a_fit_one_does(store: SqlFits) -> None:
    add(store, fit())
    with ThreadPoolExecutor(8) as threads:
        started = list(threads.map(lambda _: store.start("one", ME), range(32)))
    assert [attempt for attempt in started if attempt is not None] == [1]


def test_those_that_wait_stand_in_line(store: SqlFits) -> None:
    for i, name in enumerate(["c", "a", "b"]):
        add(store, fit(name, created=NOW + timedelta(seconds=i)))
    store.start("a", ME)
    assert [one.id for one in store.waiting()] == ["c", "b"]


def test_recovery_puts_the_interrupted_back_in_line(store: SqlFits) -> None:
    for name in ("a", "b", "c"):
        add(store, fit(name))
    store.start("a", ME)
    store.start("b", ME)
    store.finish("b", 1, FitStatus.SUCCESSFUL, b"{}", None)
    assert store.recover() == 1
    assert [one.id for one in store.waiting()] == ["a", "c"]
    assert store.start("a", ME) == 2


@pytest.mark.parametrize("status", list(FitStatus))
def test_only_what_has_ended_is_removed(store: SqlFits, status: FitStatus) -> None:
    bring(store, status)
    assert store.remove("one", list) is status.final
    assert (store.get("one") is None) is status.final


def test_an_input_goes_with_the_last_fit_that_has_it(store: SqlFits) -> None:
    for name in ("a", "b"):
        add(store, fit(name, blob="54a3d"))
        store.dismiss(name)
    dropped: list[str] = []
    assert store.remove("a", dropped.append)
    assert dropped == []
    assert store.remove("b", dropped.append)
    assert dropped == ["54a3d"]
    assert not store.remove("b", dropped.append)


def test_only_an_input_that_no_fit_has_is_discarded(store: SqlFits) -> None:
    add(store, fit("a", blob="54a3d"))
    assert store.unused(["54a3d", "1ef7"]) == ["1ef7"]
    dropped: list[str] = []
    assert not store.discard("54a3d", dropped.append)
    assert store.discard("1ef7", dropped.append)
    assert dropped == ["1ef7"]


def test_an_input_is_not_discarded_while_a_fit_with_it_is_on_its_way(store: SqlFits) -> None:
    dropped: list[str] = []
    with ThreadPoolExecutor(1) as threads:
        other: list[Future[bool]] = []

        def keep() -> None:  # the input is there, the fit not yet
            other.append(threads.submit(store.discard, "b10b", dropped.append))
            time.sleep(0.3)

        store.add(fit(), keep)
        assert not other[0].result()
    assert dropped == []


def test_a_key_gets_the_fit_that_it_came_with_first_and_no_other_payload(store: SqlFits) -> None:
    first = add(store, fit("a", key="k", payload="p"))
    assert add(store, fit("b", key="k", payload="p")) == first
    store.start("a", ME)
    again = add(store, fit("c", key="k", payload="p"))
    assert (again.id, again.status) == ("a", FitStatus.RUNNING)
    with pytest.raises(KeyReusedError):
        add(store, fit("d", key="k", payload="q"))
    assert [store.get(name) for name in "bcd"] == [None] * 3
    for name in ("e", "f"):
        assert add(store, fit(name)).id == name  # without a key, every fit is another one


def test_of_many_with_one_key_one_is_stored(store: SqlFits) -> None:
    with ThreadPoolExecutor(8) as threads:
        stored = list(threads.map(lambda i: add(store, fit(f"{i}", key="k", payload="p")).id, range(32)))
    assert len(set(stored)) == 1
    assert store.count_waiting() == 1


def test_no_more_wait_than_may_and_those_with_a_known_key_are_still_answered(store: SqlFits) -> None:
    for i in range(LIMIT):
        add(store, fit(f"{i}", key=f"{i}", payload="p", cost=12.0))
    kept: list[int] = []
    with pytest.raises(QueueFullError) as full:
        store.add(fit("more"), lambda: kept.append(1))
    assert not kept
    assert full.value.retry_after == pytest.approx(12.0)
    assert add(store, fit("again", key="3", payload="p")).id == "3"
    store.start("0", ME)
    add(store, fit("more"))


def test_what_cannot_be_kept_is_not_accepted(store: SqlFits) -> None:
    def fail() -> None:
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        store.add(fit(), fail)
    assert store.get("one") is None


def test_a_lease_that_ran_out_lets_another_take_over(store: SqlFits) -> None:
    add(store, fit())
    assert store.start("one", LeaseHolder("me", 0.5)) == 1
    assert store.start("one", OTHER) is None
    time.sleep(0.6)
    assert store.start("one", OTHER) == 2
    assert not store.renew("one", 1, 60.0)
    assert not store.report("one", 1, [{"degree": 1}])
    assert not store.finish("one", 1, FitStatus.SUCCESSFUL, b"stale", None)
    assert store.renew("one", 2, 60.0)
    assert store.finish("one", 2, FitStatus.SUCCESSFUL, b"fresh", None)


def test_of_many_who_take_a_fit_over_one_does(store: SqlFits) -> None:
    add(store, fit())
    store.start("one", LeaseHolder("dead", 0.0))
    time.sleep(0.01)
    with ThreadPoolExecutor(8) as threads:
        started = list(threads.map(lambda _: store.start("one", OTHER), range(32)))
    assert [attempt for attempt in started if attempt is not None] == [2]


def test_a_renewed_lease_holds(store: SqlFits) -> None:
    add(store, fit())
    store.start("one", LeaseHolder("me", 0.05))
    assert store.renew("one", 1, 60.0)
    time.sleep(0.1)
    assert store.start("one", OTHER) is None


def test_a_fit_that_outlives_too_many_supervisors_fails(store: SqlFits) -> None:
    add(store, fit())
    for attempt in range(1, MAX_ABANDONED + 1):
        assert store.start("one", LeaseHolder("me", 0.0)) == attempt
        time.sleep(0.01)
    assert store.start("one", ME) is None
    found = store.get("one")
    assert found is not None
    assert found.failure is not None
    assert (found.status, found.failure.kind) == (FitStatus.FAILED, "worker-crashed")


def test_crashes_are_counted_and_releases_are_not(store: SqlFits) -> None:
    add(store, fit())
    for attempt, crashed in enumerate([False, True, False, True], start=1):
        store.start("one", ME)
        assert store.release("one", attempt, crashed=crashed)
    found = store.get("one")
    assert found is not None
    assert (found.crashes, found.attempt) == (2, 4)


def test_progress_is_kept_until_the_attempt_ends(store: SqlFits) -> None:
    bring(store, FitStatus.RUNNING)
    assert store.progress("one") == []
    assert store.report("one", 1, [{"degree": 1}, {"degree": 2}])
    assert store.progress("one") == [{"degree": 1}, {"degree": 2}]
    store.release("one", 1)
    assert store.progress("one") == []


def test_old_fits_and_the_oldest_beyond_a_size_are_outdated(store: SqlFits) -> None:
    for name in ("a", "b", "c", "live"):
        add(store, fit(name))
    for name in ("a", "b", "c"):
        store.start(name, ME)
        store.finish(name, 1, FitStatus.SUCCESSFUL, bytes(500), None)
    assert store.outdated(60.0, 4500) == []
    assert store.outdated(60.0, 4499) == ["a"]
    assert store.outdated(60.0, 1500) == ["a", "b"]
    time.sleep(0.01)
    assert store.outdated(0.001, 4500) == ["a", "b", "c"]


def test_everything_is_there_when_the_file_is_opened_again(tmp_path: Path) -> None:
    for _ in range(2):
        engine = sqlite_engine(tmp_path / "fits.sqlite")
        store = SqlFits(engine, LIMIT)
        if store.get("one") is None:
            add(store, fit())
            lost = True
        else:
            lost = False
        engine.dispose()
    assert not lost


def test_commits_are_flushed_to_disk(tmp_path: Path) -> None:
    engine = sqlite_engine(tmp_path / "fits.sqlite")
    with engine.connect() as connection:
        assert connection.execute(text("PRAGMA journal_mode")).scalar() == "wal"
        assert connection.execute(text("PRAGMA synchronous")).scalar() == 2  # FULL
    engine.dispose()


@pytest.fixture
def shared(database: Engine) -> SqlFits:
    with database.begin() as connection:
        connection.execute(text("TRUNCATE fits, procrastinate_jobs CASCADE"))
    return SqlFits(database, LIMIT, ProcrastinateJobs())


def test_a_fit_and_its_job_are_stored_together_or_not_at_all(shared: SqlFits, database: Engine) -> None:
    add(shared, fit())
    assert jobs(database) == ["todo"]
    with database.begin() as connection:
        connection.execute(text("ALTER TABLE procrastinate_jobs RENAME TO elsewhere"))
    with pytest.raises(ConnectorException):
        add(shared, fit("two"))
    with database.begin() as connection:
        connection.execute(text("ALTER TABLE elsewhere RENAME TO procrastinate_jobs"))
    assert shared.get("two") is None
    assert shared.dismiss("one")
    assert jobs(database) == ["cancelled"]


def test_a_job_that_a_wrong_clock_put_off_is_replaced(shared: SqlFits, database: Engine) -> None:
    add(shared, fit())
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET scheduled_at = now() + interval '1 minute'"))
        connection.execute(text("UPDATE fits SET touched = now() - interval '1 hour'"))
    assert shared.requeue_lost(60.0) == 0
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET scheduled_at = now() + interval '1 day'"))
    assert shared.requeue_lost(60.0) == 1
    assert shared.requeue_lost(0.0) == 0


def test_a_live_fit_that_lost_its_job_gets_another_and_no_other_does(shared: SqlFits, database: Engine) -> None:
    for name in ("lost", "waits", "runs", "ended"):
        add(shared, fit(name))
    shared.start("runs", ME)
    shared.dismiss("ended")
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET status = 'failed' WHERE args->>'fit_id' <> 'waits'"))
    assert shared.requeue_lost(60.0) == 1
    assert sorted(jobs(database)) == ["failed"] * 3 + ["todo"] * 2
    assert shared.requeue_lost(0.0) == 0
