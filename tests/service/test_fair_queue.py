"""The order of the fair queue: each client gets the same share, whatever the others send."""

import sys
from datetime import UTC, datetime
from itertools import count

from hypothesis import given
from hypothesis import strategies as st

from service.jobs.fit import SHORT_SECONDS, Fit, FitStatus, PointSetRef
from service.jobs.requested_options import RequestedOptions
from service.queue.fair_queue import FairQueue

NAMES = count()
EPS = sys.float_info.epsilon
COSTS = st.floats(0.05, 100.0)


def fit(client: str, cost: float) -> Fit:
    name = f"{client} {next(NAMES)}"
    return Fit(name, FitStatus.ACCEPTED, PointSetRef("", 3, 9), RequestedOptions({}), datetime.now(UTC), client, cost)


def served(queue: FairQueue, *, short: bool = False) -> list[str]:
    """Return the ids of all fits, in the order in which they are taken."""
    taken = []
    while (one := queue.take(short=short)) is not None:
        taken.append(one)
    return taken


@given(st.lists(st.tuples(st.sampled_from("abc"), COSTS), max_size=40))
def test_everybody_is_served_once_and_a_clients_own_fits_in_order(sent: list[tuple[str, float]]) -> None:
    queue, fits = FairQueue(), [fit(client, cost) for client, cost in sent]
    for one in fits:
        queue.add(one)
    taken = served(queue)
    assert sorted(taken) == sorted(one.id for one in fits)
    for client in "abc":
        assert [name for name in taken if name[0] == client] == [one.id for one in fits if one.client == client]


@given(st.lists(COSTS, min_size=20, max_size=20), st.lists(COSTS, min_size=20, max_size=20))
def test_while_two_clients_wait_neither_gets_more_than_one_fit_ahead(a: list[float], b: list[float]) -> None:
    queue, cost, had = FairQueue(), {}, {"a": 0.0, "b": 0.0}
    for client, costs in (("a", a), ("b", b)):
        for seconds in costs:
            one = fit(client, seconds)
            cost[one.id] = seconds
            queue.add(one)
    left = {"a": 20, "b": 20}
    while all(left.values()):
        taken = queue.take()
        assert taken is not None
        had[taken[0]] += cost[taken]
        left[taken[0]] -= 1
        rounding = 40 * EPS * sum(had.values())
        assert abs(had["a"] - had["b"]) <= max(cost.values()) + rounding


def test_a_client_that_comes_late_is_not_paid_for_the_time_before() -> None:
    queue = FairQueue()
    for _ in range(10):
        queue.add(fit("early", 10.0))
    for _ in range(6):
        queue.take()
    for _ in range(4):
        queue.add(fit("late", 10.0))
    assert [name[0] for name in served(queue)] in (list("lelelele"), list("elelelel"))


def test_no_stream_of_new_clients_keeps_one_waiting_for_good() -> None:
    queue = FairQueue()
    patient = [fit("patient", 10.0) for _ in range(2)]
    for one in patient:
        queue.add(one)
    taken = []
    for i in range(100):
        queue.add(fit(f"new {i}", 10.0))
        taken.append(queue.take())
    assert patient[1].id in taken


def test_the_short_lane_takes_short_fits_only() -> None:
    queue = FairQueue()
    sent = [fit("a", SHORT_SECONDS * 2), fit("a", SHORT_SECONDS), fit("b", SHORT_SECONDS / 2)]
    for one in sent:
        queue.add(one)
    assert sorted(served(queue, short=True)) == sorted(one.id for one in sent[1:])
    assert served(queue) == [sent[0].id]


def test_the_short_lane_leaves_room_for_who_has_no_short_fit_running() -> None:
    queue = FairQueue()
    flood, long = [fit("flood", 1.0) for _ in range(4)], fit("long", 10.0 * SHORT_SECONDS)
    for one in (*flood, long):
        queue.add(one)
    assert queue.take() == flood[0].id
    assert queue.take(short=True) is None
    other, own = fit("other", 1.0), fit("long", 1.0)
    queue.add(other)
    assert queue.take(short=True) == other.id
    assert queue.take() == long.id
    queue.add(own)
    assert queue.take(short=True) == own.id  # its long fit does not count
    queue.ended(flood[0].id)
    assert queue.take(short=True) == flood[1].id


def test_who_left_is_not_served() -> None:
    queue, one, other = FairQueue(), fit("a", 1.0), fit("a", 1.0)
    for each in (one, other):
        queue.add(each)
    queue.remove(one)
    queue.remove(one)
    assert served(queue) == [other.id]
