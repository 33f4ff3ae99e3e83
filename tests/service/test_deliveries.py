"""Delivering callbacks, from the database to real receivers: retries, limits, and what a try leaves behind."""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import pytest

from service.callbacks.addresses import AllowedAddresses
from service.callbacks.sender import HttpSender
from service.callbacks.signature import Signer
from service.jobs.callback import MAX_TRIES, Callback, CallbackState
from service.jobs.deliveries import MOST_AT_ONCE, MOST_PER_HOST, Deliveries
from service.store.callbacks import SqlCallbacks
from service.store.fits import SqlFits
from tests.service.receivers import SECRET, receiver
from tests.service.stores import fit

Bench = tuple[SqlFits, SqlCallbacks]


@pytest.fixture
def bench(store: SqlFits) -> Bench:
    return store, SqlCallbacks(store._engine)  # noqa: SLF001 - the tables have no other way in


def ended(store: SqlFits, name: str, url: str) -> None:
    store.add(fit(name, callback=Callback(url)), list)
    assert store.dismiss(name)


def callback(store: SqlFits, name: str) -> Callback:
    found = store.get(name)
    assert found is not None
    assert found.callback is not None
    return found.callback


def over(store: SqlFits, *names: str) -> Callable[[], bool]:
    return lambda: all(callback(store, name).state is not CallbackState.PENDING for name in names)


def sender() -> HttpSender:
    return HttpSender(Signer.of(SECRET), AllowedAddresses.of("127.0.0.0/8"), allow_http=True)


@asynccontextmanager
async def delivering(*deliveries: Deliveries) -> AsyncIterator[list[asyncio.Task[None]]]:
    """Deliver in the background, as so many processes would."""
    tasks = [asyncio.create_task(one.keep_delivering()) for one in deliveries]
    yield tasks
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


async def reached(so: Callable[[], bool]) -> None:
    async with asyncio.timeout(60.0):
        while not await asyncio.to_thread(so):  # noqa: ASYNC110 - the store tells nobody
            await asyncio.sleep(0.02)


def deliver(callbacks: SqlCallbacks, until: Callable[[], bool], pauses: list[float] | None = None) -> None:
    """Deliver what is due, without pauses, until something is so; with `pauses`, add those that were asked for."""

    def pause(_tries: int, asked: float) -> float:
        if pauses is not None:
            pauses.append(asked)
        return 0.0

    async def script() -> None:
        async with delivering(Deliveries(callbacks, sender(), "/ipfit/v1/fits", pause)):
            await reached(until)

    asyncio.run(script())


def change(store: SqlFits, statement: str) -> None:
    with store._engine.begin() as connection:  # noqa: SLF001 - the tables have no other way in
        connection.exec_driver_sql(statement)


def test_a_message_is_sent_once_if_it_is_taken(bench: Bench) -> None:
    store, callbacks = bench
    with receiver(202) as to:
        ended(store, "one", f"{to.url}/hook?a=b")
        deliver(callbacks, over(store, "one"))
        deliver(callbacks, lambda: True)
        (message,) = to.messages
    found = store.get("one")
    assert found is not None
    assert found.finished is not None
    assert message.signed_with(SECRET)
    assert message.event == {
        "type": "fit.ended",
        "timestamp": found.finished.isoformat().replace("+00:00", "Z"),
        "data": {"id": "one", "status": "dismissed", "path": "/ipfit/v1/fits/one"},
    }
    assert callback(store, "one") == Callback(f"{to.url}/hook?a=b", CallbackState.DELIVERED, 1)


def test_a_failed_try_is_followed_by_others_with_the_same_id_and_body(bench: Bench) -> None:
    store, callbacks = bench
    with receiver(500, 404, b"", 301, 200) as to:
        ended(store, "one", to.url)
        deliver(callbacks, over(store, "one"))
        assert len(to.messages) == 5
        assert len({(message.id, message.body) for message in to.messages}) == 1
        assert all(message.signed_with(SECRET) for message in to.messages)
    assert callback(store, "one") == Callback(to.url, CallbackState.DELIVERED, 5)


def test_a_callback_is_given_up_after_the_last_try(bench: Bench, caplog: pytest.LogCaptureFixture) -> None:
    store, callbacks = bench
    with receiver(500) as to, caplog.at_level(logging.WARNING):
        ended(store, "one", f"{to.url}/?token=hunter2")
        deliver(callbacks, over(store, "one"))
        assert len(to.messages) == MAX_TRIES
    now = callback(store, "one")
    assert (now.state, now.tries, now.last_error) == (CallbackState.FAILED, MAX_TRIES, "the receiver answered 500")
    assert "the callback of fit one to 127.0.0.1 is given up: the receiver answered 500" in caplog.text
    assert "hunter2" not in caplog.text


def test_a_last_try_that_a_crash_cut_off_is_the_last(bench: Bench) -> None:
    store, callbacks = bench
    with receiver() as to:
        ended(store, "one", to.url)
        for _ in range(MAX_TRIES):
            assert callbacks.take_due((), (), 0.0) is not None
        deliver(callbacks, over(store, "one"))
        assert to.messages == []
    assert callback(store, "one").last_error == "the last try was interrupted"


def test_a_receiver_that_is_gone_is_not_asked_again(bench: Bench) -> None:
    store, callbacks = bench
    with receiver(410, 200) as to:
        ended(store, "one", to.url)
        deliver(callbacks, over(store, "one"))
        assert len(to.messages) == 1
    assert callback(store, "one") == Callback(to.url, CallbackState.FAILED, 1, "the receiver answered 410")


def test_a_receiver_may_ask_for_a_pause_if_it_is_busy_and_only_then(bench: Bench) -> None:
    store, callbacks = bench
    pauses: list[float] = []
    with receiver(503, 429, 500, 200, headers={"Retry-After": "77"}) as to:
        ended(store, "one", to.url)
        deliver(callbacks, over(store, "one"), pauses)
    assert pauses == [77.0, 77.0, 0.0]


def test_what_may_not_be_sent_to_is_an_error_of_the_try(bench: Bench) -> None:
    store, callbacks = bench
    ended(store, "one", "http://10.0.0.1/")
    deliver(callbacks, over(store, "one"))
    now = callback(store, "one")
    assert (now.state, now.tries) == (CallbackState.FAILED, MAX_TRIES)
    assert now.last_error == "the host has no address, or not only public ones"


def test_a_receiver_that_is_slow_holds_up_nobody_else(bench: Bench) -> None:
    """More callbacks wait for it than are sent at once, and they have waited longer."""
    store, callbacks = bench
    with receiver(held=True) as slow, receiver() as quick:
        for i in range(MOST_AT_ONCE + 1):
            ended(store, f"slow-{i}", slow.url)
        ended(store, "quick", quick.url)
        change(store, "UPDATE callbacks SET host = 'quick' WHERE fit = 'quick'")  # both are at one address
        deliver(callbacks, over(store, "quick"))
        assert len(quick.messages) == 1
        assert len(slow.messages) == MOST_PER_HOST
        assert callback(store, "slow-0").state is CallbackState.PENDING


def test_a_try_that_was_cut_off_is_made_again(bench: Bench) -> None:
    store, callbacks = bench
    with receiver(held=True) as to:
        ended(store, "one", to.url)
        deliver(callbacks, lambda: bool(to.messages))
        assert callback(store, "one") == Callback(to.url, CallbackState.PENDING, 1)
        change(store, "UPDATE callbacks SET due = ended")  # its lease has run out
        to.go_on.set()
        deliver(callbacks, over(store, "one"))
        assert [message.id for message in to.messages] == ["ended-one"] * 2
    assert callback(store, "one").state is CallbackState.DELIVERED


def test_many_are_delivered_by_several_processes_once_each(bench: Bench) -> None:
    store, callbacks = bench
    names = [f"fit-{i}" for i in range(30)]

    async def script() -> None:
        async with delivering(*(Deliveries(callbacks, sender(), "") for _ in range(3))):
            await reached(over(store, *names))

    with receiver() as to:
        for name in names:
            ended(store, name, to.url)
        asyncio.run(script())
        assert sorted(message.id for message in to.messages) == sorted(f"ended-{name}" for name in names)


def test_a_store_that_fails_is_asked_again(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.jobs.deliveries.STORE_PAUSE", 0.05)
    store, callbacks = bench

    async def script() -> None:
        change(store, "ALTER TABLE callbacks RENAME TO away")
        async with delivering(Deliveries(callbacks, sender(), "")) as (task,):
            await asyncio.sleep(0.3)
            assert not task.done()
            change(store, "ALTER TABLE away RENAME TO callbacks")
            await reached(over(store, "one"))

    with receiver() as to:
        ended(store, "one", to.url)
        asyncio.run(script())
        assert len(to.messages) == 1
