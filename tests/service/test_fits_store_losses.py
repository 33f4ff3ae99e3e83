"""Fits in the store whose supervisor or job is lost: another takes over, and each has its job."""

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from procrastinate.exceptions import ConnectorException
from sqlalchemy import Engine, text

from service.jobs.fit import MAX_ABANDONED, FitStatus
from service.jobs.lease_holder import LeaseHolder
from service.store.fits import SqlFits
from tests.service.stores import ME, OTHER, add, fit, jobs, start


def test_recovery_puts_the_interrupted_back_in_line(store: SqlFits) -> None:
    for name in ("a", "b", "c"):
        add(store, fit(name))
    start(store, "a", ME)
    start(store, "b", ME)
    store.finish("b", 1, FitStatus.SUCCESSFUL, b"{}", None)
    assert store.recover() == 1
    assert [one.id for one in store.waiting()] == ["a", "c"]
    assert start(store, "a", ME) == 2


def test_a_lease_that_ran_out_lets_another_take_over(store: SqlFits) -> None:
    add(store, fit())
    assert start(store, "one", LeaseHolder("me", 0.5)) == 1
    assert start(store, "one", OTHER) is None
    time.sleep(0.6)
    assert start(store, "one", OTHER) == 2
    assert not store.renew("one", 1, 60.0)
    assert not store.report("one", 1, [{"degree": 1}])
    assert not store.finish("one", 1, FitStatus.SUCCESSFUL, b"stale", None)
    assert store.renew("one", 2, 60.0)
    assert store.finish("one", 2, FitStatus.SUCCESSFUL, b"fresh", None)


def test_of_many_who_take_a_fit_over_one_does(store: SqlFits) -> None:
    add(store, fit())
    start(store, "one", LeaseHolder("dead", 0.0))
    time.sleep(0.01)
    with ThreadPoolExecutor(8) as threads:
        started = list(threads.map(lambda _: start(store, "one", OTHER), range(32)))
    assert [attempt for attempt in started if attempt is not None] == [2]


def test_a_renewed_lease_holds(store: SqlFits) -> None:
    add(store, fit())
    start(store, "one", LeaseHolder("me", 0.05))
    assert store.renew("one", 1, 60.0)
    time.sleep(0.1)
    assert start(store, "one", OTHER) is None


def test_a_fit_that_outlives_too_many_supervisors_fails(store: SqlFits) -> None:
    add(store, fit())
    for attempt in range(1, MAX_ABANDONED + 1):
        assert start(store, "one", LeaseHolder("me", 0.0)) == attempt
        time.sleep(0.01)
    assert start(store, "one", ME) is None
    found = store.get("one")
    assert found is not None
    assert found.failure is not None
    assert (found.status, found.failure.kind) == (FitStatus.FAILED, "worker-crashed")


def test_crashes_are_counted_and_releases_are_not(store: SqlFits) -> None:
    add(store, fit())
    for attempt, crashed in enumerate([False, True, False, True], start=1):
        start(store, "one", ME)
        assert store.release("one", attempt, crashed=crashed)
    found = store.get("one")
    assert found is not None
    assert (found.crashes, found.attempt) == (2, 4)


def test_a_fit_and_its_job_are_stored_together_or_not_at_all(cluster_store: SqlFits, database: Engine) -> None:
    add(cluster_store, fit())
    assert jobs(database) == ["todo"]
    with database.begin() as connection:
        connection.execute(text("ALTER TABLE procrastinate_jobs RENAME TO elsewhere"))
    with pytest.raises(ConnectorException):
        add(cluster_store, fit("two"))
    with database.begin() as connection:
        connection.execute(text("ALTER TABLE elsewhere RENAME TO procrastinate_jobs"))
    assert cluster_store.get("two") is None
    assert cluster_store.dismiss("one")
    assert jobs(database) == ["cancelled"]


def test_a_job_that_a_wrong_clock_put_off_is_replaced(cluster_store: SqlFits, database: Engine) -> None:
    add(cluster_store, fit())
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET scheduled_at = now() + interval '1 minute'"))
        connection.execute(text("UPDATE fits SET touched = now() - interval '1 hour'"))
    assert cluster_store.requeue_lost(60.0) == 0
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET scheduled_at = now() + interval '1 day'"))
    assert cluster_store.requeue_lost(60.0) == 1
    assert cluster_store.requeue_lost(0.0) == 0


def test_a_live_fit_that_lost_its_job_gets_another_and_no_other_does(cluster_store: SqlFits, database: Engine) -> None:
    for name in ("lost", "waits", "runs", "ended"):
        add(cluster_store, fit(name))
    start(cluster_store, "runs", ME)
    cluster_store.dismiss("ended")
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET status = 'failed' WHERE args->>'fit_id' <> 'waits'"))
    assert cluster_store.requeue_lost(60.0) == 1
    assert sorted(jobs(database)) == ["failed"] * 3 + ["todo"] * 2
    assert cluster_store.requeue_lost(0.0) == 0
