"""What the fit store accepts on SQLite and on PostgreSQL: inputs, idempotency keys, and no more than may wait."""

import time
from concurrent.futures import Future, ThreadPoolExecutor

import pytest

from service.jobs.errors import KeyReusedError, QueueFullError
from service.jobs.fit import FitStatus
from service.store.fits import SqlFits
from tests.service.stores import LIMIT, ME, add, fit, start


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
    start(store, "a", ME)
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
    start(store, "0", ME)
    add(store, fit("more"))


def test_what_cannot_be_kept_is_not_accepted(store: SqlFits) -> None:
    def fail() -> None:
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        store.add(fit(), fail)
    assert store.get("one") is None
