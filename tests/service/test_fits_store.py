"""The fit store on real SQLite files: durable, and no move but the legal ones."""

import dataclasses
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from sqlalchemy import text

from service.jobs.fit import MOVES, Failure, Fit, FitStatus, PointSetRef
from service.store.fits import SqlFits, sqlite_engine

NOW = datetime(2026, 11, 22, 20, 15, 30, 123456, UTC)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[SqlFits]:
    engine = sqlite_engine(tmp_path / "fits.sqlite")
    yield SqlFits(engine)
    engine.dispose()


def fit(fit_id: str = "one", key: str = "k", created: datetime = NOW) -> Fit:
    return Fit(fit_id, FitStatus.ACCEPTED, PointSetRef(key, 3, 100), {"t1": 0.02}, created)


def bring(store: SqlFits, status: FitStatus) -> None:
    """Add a fit and bring it to this status."""
    store.add(fit())
    if status is FitStatus.DISMISSED:
        store.dismiss("one")
    elif status is not FitStatus.ACCEPTED:
        store.start("one")
    if status in (FitStatus.SUCCESSFUL, FitStatus.FAILED):
        store.finish("one", 1, status, None, None)


def test_what_was_added_comes_back(store: SqlFits) -> None:
    store.add(fit())
    assert store.get("one") == fit()
    assert store.get("two") is None


def test_a_successful_life(store: SqlFits) -> None:
    store.add(fit())
    assert store.start("one") == 1
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
    (FitStatus.RUNNING, lambda store: store.start("one")),
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
    legal = target in MOVES[status]
    assert bool(action(store)) is legal
    after = store.get("one")
    assert after is not None
    assert after.status is (target if legal else status)
    assert legal or after == before


def test_only_the_attempt_that_holds_a_fit_may_end_it(store: SqlFits) -> None:
    bring(store, FitStatus.RUNNING)
    assert store.release("one", 1)
    assert store.start("one") == 2
    assert not store.finish("one", 1, FitStatus.SUCCESSFUL, b"stale", None)
    assert not store.release("one", 1)
    assert store.finish("one", 2, FitStatus.SUCCESSFUL, b"fresh", None)
    found = store.get("one")
    assert found is not None
    assert found.result == b"fresh"


def test_of_many_who_start_a_fit_one_does(store: SqlFits) -> None:
    store.add(fit())
    with ThreadPoolExecutor(8) as threads:
        started = list(threads.map(lambda _: store.start("one"), range(32)))
    assert [attempt for attempt in started if attempt is not None] == [1]


def test_those_that_wait_stand_in_line(store: SqlFits) -> None:
    for i, name in enumerate(["c", "a", "b"]):
        store.add(fit(name, created=NOW + timedelta(seconds=i)))
    store.start("a")
    assert store.waiting() == ["c", "b"]


def test_recovery_puts_the_interrupted_back_in_line(store: SqlFits) -> None:
    for name in ("a", "b", "c"):
        store.add(fit(name))
    store.start("a")
    store.start("b")
    store.finish("b", 1, FitStatus.SUCCESSFUL, b"{}", None)
    assert store.recover() == 1
    assert store.waiting() == ["a", "c"]
    assert store.start("a") == 2


@pytest.mark.parametrize("status", list(FitStatus))
def test_only_what_has_ended_is_removed(store: SqlFits, status: FitStatus) -> None:
    bring(store, status)
    assert store.remove("one") is status.final
    assert (store.get("one") is None) is status.final


def test_a_blob_is_in_use_while_any_fit_has_it(store: SqlFits) -> None:
    for name in ("a", "b"):
        store.add(fit(name, key="shared"))
        store.dismiss(name)
    store.remove("a")
    assert store.uses("shared")
    store.remove("b")
    assert not store.uses("shared")


def test_everything_is_there_when_the_file_is_opened_again(tmp_path: Path) -> None:
    for _ in range(2):
        engine = sqlite_engine(tmp_path / "fits.sqlite")
        store = SqlFits(engine)
        if store.get("one") is None:
            store.add(fit())
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
