"""Callbacks on SQLite and on PostgreSQL: due when their fits end, taken by one process at a time, never lost."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from sqlalchemy import Engine, text

from service.jobs.callback import Callback, CallbackState
from service.jobs.delivery import Delivery, Outcome
from service.jobs.fit import MAX_ABANDONED, Failure, FitStatus
from service.jobs.parts import split
from service.jobs.slices import Frame
from service.store.callbacks import SqlCallbacks
from service.store.fits import SqlFits
from tests.service.stores import ME, fit, start

HOOK = Callback("https://Hooks.example:8443/a?b=c")
DELIVERED = Outcome(CallbackState.DELIVERED)
FAILED = Outcome(CallbackState.FAILED, "gone")


def again(pause: float) -> Outcome:
    return Outcome(CallbackState.PENDING, "away", pause)


@pytest.fixture
def callbacks(store: SqlFits) -> SqlCallbacks:
    return SqlCallbacks(engine_of(store))


def engine_of(store: SqlFits) -> Engine:
    return store._engine  # noqa: SLF001 - the tables have no other way in


def rows(store: SqlFits) -> list[str]:
    with engine_of(store).connect() as connection:
        return list(connection.execute(text("SELECT fit FROM callbacks ORDER BY fit")).scalars())


def ended(store: SqlFits, name: str = "one", url: str = HOOK.url, client: str = "") -> None:
    """Add a fit with a callback, and end it."""
    store.add(fit(name, callback=Callback(url), client=client), list)
    start(store, name, ME)
    assert store.finish(name, 1, FitStatus.SUCCESSFUL, b"{}", None)


def taken(callbacks: SqlCallbacks, lease: float = 60.0) -> Delivery:
    found = callbacks.take_due((), (), lease)
    assert found is not None
    return found


def shown(store: SqlFits, name: str = "one") -> Callback | None:
    found = store.get(name)
    assert found is not None
    return found.callback


def die_again_and_again(store: SqlFits) -> None:
    for _ in range(MAX_ABANDONED):
        start(store, "one", ME)
        store.recover()


@pytest.mark.parametrize(
    ("end", "status"),
    [
        (lambda store: store.finish("one", start(store, "one", ME), FitStatus.SUCCESSFUL, b"{}", None), "successful"),
        (
            lambda store: store.finish("one", start(store, "one", ME), FitStatus.FAILED, None, Failure("a", "b")),
            "failed",
        ),
        (lambda store: store.dismiss("one"), "dismissed"),
        (die_again_and_again, "failed"),
    ],
    ids=["finished", "failed", "dismissed", "abandoned"],
)
def test_a_callback_is_due_when_its_fit_has_ended_however(
    store: SqlFits, callbacks: SqlCallbacks, end: Callable[[SqlFits], object], status: str
) -> None:
    store.add(fit(callback=HOOK), list)
    assert callbacks.take_due((), (), 60.0) is None
    assert shown(store) == HOOK
    end(store)
    found, now = taken(callbacks), store.get("one")
    assert now is not None
    assert now.finished is not None
    assert found == Delivery("one", HOOK.url, "hooks.example", "", FitStatus(status), now.finished, 1)
    assert shown(store) == replace(HOOK, tries=1)


def test_a_fit_without_one_makes_nothing_due(store: SqlFits, callbacks: SqlCallbacks) -> None:
    store.add(fit(), list)
    store.dismiss("one")
    assert callbacks.take_due((), (), 60.0) is None
    assert rows(store) == []


def test_a_request_that_is_repeated_finds_the_callback_of_the_first(store: SqlFits) -> None:
    store.add(fit(callback=HOOK, key="again", payload="same"), list)
    again, _ = store.add(fit("two", callback=HOOK, key="again", payload="same"), list)
    assert (again.id, again.callback) == ("one", HOOK)


def test_a_fit_in_parts_has_one_callback(store: SqlFits, callbacks: SqlCallbacks) -> None:
    whole, parts = split(fit(callback=HOOK), Frame((0.0, 0.0, 0.0), 1.0), 50)
    store.add(whole, list, parts)
    assert rows(store) == ["one"]
    for one in (*parts, whole):
        assert callbacks.take_due((), (), 60.0) is None
        assert start(store, one.id, ME) == 1
        assert store.finish(one.id, 1, FitStatus.SUCCESSFUL, b"{}", None)
    assert taken(callbacks).status is FitStatus.SUCCESSFUL
    assert callbacks.take_due((), (), 60.0) is None


def test_a_fit_that_fails_with_a_part_has_one_too(store: SqlFits, callbacks: SqlCallbacks) -> None:
    whole, parts = split(fit(callback=HOOK), Frame((0.0, 0.0, 0.0), 1.0), 50)
    store.add(whole, list, parts)
    start(store, parts[1].id, ME)
    assert store.finish(parts[1].id, 1, FitStatus.FAILED, None, Failure("a", "b"))
    assert (taken(callbacks).status, callbacks.take_due((), (), 60.0)) == (FitStatus.FAILED, None)


def test_of_many_who_look_each_takes_another_one(store: SqlFits, callbacks: SqlCallbacks) -> None:
    names = [f"fit-{i}" for i in range(10)]
    for name in names:
        ended(store, name)

    def take(_: int) -> list[str]:
        mine = []
        for _try in range(20):
            found = callbacks.take_due((), (), 60.0)
            mine += [found.fit_id] if found is not None else []
        return mine

    with ThreadPoolExecutor(6) as threads:
        found = [name for mine in threads.map(take, range(6)) for name in mine]
    assert sorted(found) == names


@pytest.mark.parametrize("store", ["postgresql"], indirect=True)
def test_nobody_waits_for_a_process_that_is_taking_one(store: SqlFits, callbacks: SqlCallbacks) -> None:
    for name in ("one", "two"):
        ended(store, name)
    with engine_of(store).begin() as other:
        other.exec_driver_sql("SELECT * FROM callbacks WHERE fit = 'one' FOR UPDATE")
        other.exec_driver_sql("SET LOCAL idle_in_transaction_session_timeout = 5000")
        assert taken(callbacks).fit_id == "two"


def test_what_a_dead_process_took_is_due_again_after_its_lease(store: SqlFits, callbacks: SqlCallbacks) -> None:
    ended(store)
    first = taken(callbacks, 0.2)
    assert callbacks.take_due((), (), 60.0) is None
    time.sleep(0.25)
    second = taken(callbacks)
    assert (first.tries, second.tries) == (1, 2)
    assert second.message_id == first.message_id
    assert second.body("/v1/fits") == first.body("/v1/fits")
    assert not callbacks.record(first, FAILED)  # the process was only slow
    assert callbacks.record(second, DELIVERED)
    assert shown(store) == replace(HOOK, state=CallbackState.DELIVERED, tries=2)


def test_a_failed_try_is_followed_by_another_after_its_pause(store: SqlFits, callbacks: SqlCallbacks) -> None:
    ended(store)
    assert callbacks.record(taken(callbacks), again(60.0))
    assert callbacks.take_due((), (), 60.0) is None
    assert shown(store) == replace(HOOK, tries=1, last_error="away")
    ended(store, "two")
    assert callbacks.record(taken(callbacks), again(0.0))
    assert taken(callbacks) == replace(taken_as("two", store), tries=2, last_error="away")


def taken_as(name: str, store: SqlFits) -> Delivery:
    found = store.get(name)
    assert found is not None
    assert found.finished is not None
    return Delivery(name, HOOK.url, "hooks.example", "", found.status, found.finished, 1)


@pytest.mark.parametrize("outcome", [DELIVERED, FAILED])
def test_what_has_ended_is_not_sent_again(store: SqlFits, callbacks: SqlCallbacks, outcome: Outcome) -> None:
    ended(store)
    delivery = taken(callbacks, 0.0)
    assert callbacks.record(delivery, outcome)
    assert not callbacks.record(delivery, again(0.0))
    assert callbacks.take_due((), (), 60.0) is None
    assert shown(store) == replace(HOOK, state=outcome.state, tries=1, last_error=outcome.error)


def test_the_one_that_has_waited_longest_is_next_but_not_to_a_host_that_is_full(
    store: SqlFits, callbacks: SqlCallbacks
) -> None:
    for name, url in (("a", HOOK.url), ("b", HOOK.url), ("c", "https://other.example/")):
        ended(store, name, url)
    assert taken(callbacks).fit_id == "a"
    found = callbacks.take_due(["hooks.example", "third.example"], (), 60.0)
    assert found is not None
    assert found.fit_id == "c"
    assert callbacks.take_due(["hooks.example"], (), 60.0) is None
    assert taken(callbacks).fit_id == "b"


def test_a_client_who_has_enough_of_them_under_way_waits(store: SqlFits, callbacks: SqlCallbacks) -> None:
    for name, client in (("a", "ada"), ("b", "ada"), ("c", "bob")):
        ended(store, name, f"https://{name}.example/", client)
    first = taken(callbacks)
    assert (first.fit_id, first.client) == ("a", "ada")
    found = callbacks.take_due((), ["ada"], 60.0)
    assert found is not None
    assert (found.fit_id, found.client) == ("c", "bob")
    assert callbacks.take_due((), ["ada", "bob"], 60.0) is None


def test_who_removes_a_fit_is_not_told_of_it_any_more(store: SqlFits, callbacks: SqlCallbacks) -> None:
    ended(store)
    assert store.remove("one", list)
    assert rows(store) == []
    assert callbacks.take_due((), (), 60.0) is None


@pytest.mark.parametrize("outcome", [DELIVERED, FAILED])
def test_a_callback_outlives_a_fit_that_is_removed_for_its_age(
    store: SqlFits, callbacks: SqlCallbacks, outcome: Outcome
) -> None:
    ended(store)
    assert store.remove("one", list, keep_callback=True)
    assert callbacks.record(taken(callbacks), again(0.0))
    delivery = taken(callbacks)
    assert (delivery.fit_id, delivery.status) == ("one", FitStatus.SUCCESSFUL)
    assert rows(store) == ["one"]
    assert callbacks.record(delivery, outcome)
    assert rows(store) == []


def test_a_callback_that_has_ended_goes_with_its_fit(store: SqlFits, callbacks: SqlCallbacks) -> None:
    ended(store)
    assert callbacks.record(taken(callbacks), DELIVERED)
    assert rows(store) == ["one"]
    assert store.remove("one", list, keep_callback=True)
    assert rows(store) == []


def test_a_fit_that_is_removed_while_its_callback_is_sent(store: SqlFits, callbacks: SqlCallbacks) -> None:
    ended(store)
    delivery = taken(callbacks)
    store.remove("one", list)
    assert not callbacks.record(delivery, again(0.0))
    assert rows(store) == []


def test_a_live_fit_keeps_its_callback(store: SqlFits) -> None:
    store.add(fit(callback=HOOK), list)
    assert not store.remove("one", list)
    assert rows(store) == ["one"]
