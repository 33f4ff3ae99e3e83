"""The fit store on SQLite and on PostgreSQL: it is durable, and allows legal transitions only."""

import dataclasses
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path

import pytest
from sqlalchemy import exc, text

from service.jobs.admission import Admission
from service.jobs.fit import TRANSITIONS, Failure, FitStatus
from service.jobs.retention import Retention
from service.store import engines
from service.store.blobs import Blobs
from service.store.engines import sqlite_engine
from service.store.fits import SqlFits
from tests.service.stores import LIMIT, ME, NOW, add, fit, start


def bring(store: SqlFits, status: FitStatus) -> None:
    """Add a fit and bring it to this status."""
    add(store, fit())
    if status is FitStatus.DISMISSED:
        store.dismiss("one")
    elif status is not FitStatus.ACCEPTED:
        start(store, "one", ME)
    if status in (FitStatus.SUCCESSFUL, FitStatus.FAILED):
        store.finish("one", 1, status, None, None)


def test_what_was_added_comes_back(store: SqlFits) -> None:
    add(store, fit())
    assert store.get("one") == fit()
    assert store.get("two") is None


def test_a_successful_life(store: SqlFits) -> None:
    add(store, fit())
    assert start(store, "one", ME) == 1
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
    (FitStatus.RUNNING, lambda store: start(store, "one", ME)),
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
    assert start(store, "one", ME) == 2
    assert not store.finish("one", 1, FitStatus.SUCCESSFUL, b"stale", None)
    assert not store.release("one", 1)
    assert store.finish("one", 2, FitStatus.SUCCESSFUL, b"fresh", None)
    found = store.get("one")
    assert found is not None
    assert found.result == b"fresh"


def test_of_many_who_start_a_fit_one_does(store: SqlFits) -> None:
    add(store, fit())
    with ThreadPoolExecutor(8) as threads:
        started = list(threads.map(lambda _: start(store, "one", ME), range(32)))
    assert [attempt for attempt in started if attempt is not None] == [1]


def test_those_that_wait_stand_in_line(store: SqlFits) -> None:
    for i, name in enumerate(["c", "a", "b"]):
        add(store, fit(name, created=NOW + timedelta(seconds=i)))
    start(store, "a", ME)
    assert [one.id for one in store.waiting()] == ["c", "b"]


@pytest.mark.parametrize("status", list(FitStatus))
def test_only_what_has_ended_is_removed(store: SqlFits, status: FitStatus) -> None:
    bring(store, status)
    assert store.remove("one", list) is status.final
    assert (store.get("one") is None) is status.final


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
        start(store, name, ME)
        store.finish(name, 1, FitStatus.SUCCESSFUL, bytes(500), None)
    assert store.outdated(60.0, 4500) == []
    assert store.outdated(60.0, 4499) == ["a"]
    assert store.outdated(60.0, 1500) == ["a", "b"]
    time.sleep(0.01)
    assert store.outdated(0.001, 4500) == ["a", "b", "c"]
    assert store.outdated(60.0) == []


def test_many_outdated_fits_are_removed_in_several_sweeps(
    store: SqlFits, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a", "b", "c"):
        add(store, fit(name, name))
        start(store, name, ME)
        store.finish(name, 1, FitStatus.SUCCESSFUL, b"{}", None)
    monkeypatch.setattr("service.jobs.retention.LONGEST_SWEEP", 0.0)
    retention = Retention(store, Blobs(str(tmp_path)), age=60.0, size=0)
    assert [retention.sweep() for _ in range(4)] == [(1, True), (1, True), (1, False), (0, False)]


def test_fits_that_are_too_old_do_not_hide_those_that_are_too_many(store: SqlFits, tmp_path: Path) -> None:
    retention = Retention(store, Blobs(str(tmp_path)), age=0.5, size=2000)
    for name in ("a", "b", "c", "d"):
        add(store, fit(name))
        start(store, name, ME)
        store.finish(name, 1, FitStatus.SUCCESSFUL, bytes(500), None)
        if name == "a":
            time.sleep(0.6)
    assert retention.sweep() == (3, False)
    assert store.get("d") is not None


def test_the_size_of_all_fits_is_asked_for_now_and_then(
    store: SqlFits, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int | None] = []
    outdated = store.outdated

    def noted(age: float, size: int | None = None) -> list[str]:
        asked.append(size)
        return outdated(age, size)

    monkeypatch.setattr(store, "outdated", noted)
    retention = Retention(store, Blobs(str(tmp_path)), age=60.0, size=7)
    for _ in range(3):
        retention.sweep()
    assert asked == [7, None, None]


def test_everything_is_there_when_the_file_is_opened_again(tmp_path: Path) -> None:
    for _ in range(2):
        engine = sqlite_engine(tmp_path / "fits.sqlite")
        store = SqlFits(engine, Admission(LIMIT))
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


def test_writers_of_sqlite_wait_for_others_but_not_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    engine = sqlite_engine(tmp_path / "fits.sqlite")
    monkeypatch.setattr(engines, "LOCK_SECONDS", 0.2)
    write = text("DELETE FROM fits")
    with engine.connect() as first:
        first.execute(write)
        with engine.connect() as second:
            assert not second.execute(text("SELECT id FROM fits")).all()  # readers do not wait
            with pytest.raises(exc.TimeoutError, match="others have been writing for too long"):
                second.execute(write)
    with engine.begin() as third:  # the first has ended, and the second left nothing locked
        third.execute(write)
    engine.dispose()
