"""The order of a cluster's queue: each client gets the same share, whatever the others send."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import Engine, text

from service.jobs.fit import FitStatus
from service.jobs.parts import split
from service.jobs.slices import Frame
from service.store.fits import SqlFits
from service.store.schema import turns
from service.store.turns import LAST_PLACE
from tests.service.bodies import SOME_SECONDS, ellipse, npy, torus
from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.stores import ME, add, fit, start


def line(engine: Engine) -> list[str]:
    """Return the fits whose jobs wait, in the order in which Procrastinate gives them to workers."""
    query = "SELECT args->>'fit_id' FROM procrastinate_jobs WHERE status = 'todo' ORDER BY priority DESC, id"
    with engine.connect() as connection:
        return list(connection.execute(text(query)).scalars())


def fetch(engine: Engine) -> str:
    """Take the next job, as a worker does, and return its fit."""
    taken = "SELECT args->>'fit_id' FROM procrastinate_fetch_job_v2(NULL, NULL)"
    with engine.begin() as connection:
        return str(connection.execute(text(taken)).scalar_one())


def serve(store: SqlFits, engine: Engine) -> str:
    """Run the next fit to its end, and return its id."""
    name = fetch(engine)
    assert start(store, name, ME) == 1
    assert store.finish(name, 1, FitStatus.SUCCESSFUL, b"{}", None)
    return name


def test_who_sends_one_fit_does_not_wait_for_all_of_another(cluster_store: SqlFits, database: Engine) -> None:
    for number in range(20):
        add(cluster_store, fit(f"many{number:02}", client="heavy", cost=2.0))
    assert serve(cluster_store, database) == "many00"
    add(cluster_store, fit("one", client="light", cost=2.0))
    assert [serve(cluster_store, database) for _ in range(3)] == ["many01", "one", "many02"]


def test_clients_get_the_same_predicted_time(cluster_store: SqlFits, database: Engine) -> None:
    for number in range(15):
        add(cluster_store, fit(f"short{number}", client="a", cost=2.0))
        add(cluster_store, fit(f"long{number}", client="b", cost=10.0))
    served = [serve(cluster_store, database) for _ in range(12)]
    assert sum(name.startswith("short") for name in served) == 10


def test_what_has_ended_counts_while_others_wait(cluster_store: SqlFits, database: Engine) -> None:
    """Who sends long fits one after the other, and removes each when it has ended, gets no more than a share."""
    for number in range(20):
        add(cluster_store, fit(f"short{number}", client="a", cost=2.0))
    add(cluster_store, fit("long", client="b", cost=20.0))
    served: list[str] = []
    while len(served) < 13:
        served.append(serve(cluster_store, database))
        if served[-1] == "long":
            assert cluster_store.remove("long", lambda _: None)
            add(cluster_store, fit("long", client="b", cost=20.0))
    assert served.count("long") == 2


def test_who_had_nothing_to_do_saves_no_time_up(cluster_store: SqlFits, database: Engine) -> None:
    add(cluster_store, fit("earlier", client="b", cost=1.0))
    for number in range(10):
        add(cluster_store, fit(f"a{number}", client="a", cost=100.0))
    for _ in range(6):
        serve(cluster_store, database)
    for number in range(3):
        add(cluster_store, fit(f"b{number}", client="b", cost=100.0))
    assert [serve(cluster_store, database)[0] for _ in range(6)] == ["a", "b", "a", "b", "a", "b"]


def test_what_runs_counts_when_nothing_waits(cluster_store: SqlFits, database: Engine) -> None:
    add(cluster_store, fit("a0", client="a", cost=100.0))
    assert start(cluster_store, fetch(database), ME) == 1
    add(cluster_store, fit("b0", client="b", cost=50.0))
    add(cluster_store, fit("a1", client="a", cost=100.0))
    add(cluster_store, fit("b1", client="b", cost=50.0))
    assert line(database) == ["b0", "b1", "a1"]


def test_a_fit_that_is_tried_again_does_not_turn_the_time_back(cluster_store: SqlFits, database: Engine) -> None:
    add(cluster_store, fit("unreadable", client="a", cost=1.0))
    for number in range(8):
        add(cluster_store, fit(f"b{number}", client="b", cost=10.0))
    assert start(cluster_store, fetch(database), ME) == 1
    for _ in range(5):
        serve(cluster_store, database)
    assert cluster_store.release("unreadable", 1)
    for number in range(3):
        add(cluster_store, fit(f"c{number}", client="c", cost=10.0))
    assert line(database) == ["b5", "c0", "b6", "c1", "b7", "c2"]


def test_what_is_dismissed_before_it_ran_costs_nothing(cluster_store: SqlFits, database: Engine) -> None:
    for number in range(8):
        add(cluster_store, fit(f"b{number}", client="b", cost=10.0))
    for number in range(5):
        add(cluster_store, fit(f"mistake{number}", client="a", cost=60.0))
    for number in range(5):
        assert cluster_store.dismiss(f"mistake{number}")
    add(cluster_store, fit("right", client="a", cost=60.0))
    assert line(database)[:3] == ["b0", "right", "b1"]


def test_parts_come_one_after_the_other_between_fits_of_others(cluster_store: SqlFits, database: Engine) -> None:
    whole, parts = split(fit("big", client="a", cost=30.0), Frame((0.0, 0.0, 0.0), 1.0), 34)
    cluster_store.add(whole, list, parts)
    for number in range(3):
        add(cluster_store, fit(f"b{number}", client="b", cost=10.0))
    assert line(database) == ["big-00000", "b0", "big-00001", "b1", "big-00002", "b2"]


def queues(engine: Engine) -> dict[str, str]:
    """Return the queue of each fit's job."""
    with engine.connect() as connection:
        found = connection.execute(text("SELECT args->>'fit_id', queue_name FROM procrastinate_jobs")).all()
    return {name: queue for name, queue in found if name}


def test_the_lane_of_short_fits_has_one_of_each_client(cluster_store: SqlFits, database: Engine) -> None:
    for name in ("a0", "a1", "b0"):
        add(cluster_store, fit(name, client=name[0], cost=0.1))
    add(cluster_store, fit("c0", client="c", cost=1000.0))
    assert queues(database) == {"a0": "short", "a1": "long", "b0": "short", "c0": "long"}
    assert start(cluster_store, "a0", ME) == 1
    add(cluster_store, fit("a2", client="a", cost=0.1))
    assert cluster_store.finish("a0", 1, FitStatus.SUCCESSFUL, b"{}", None)
    assert (queues(database)["a1"], queues(database)["a2"]) == ("short", "long")
    assert cluster_store.dismiss("a1")
    assert queues(database)["a2"] == "short"
    assert start(cluster_store, "a2", ME) == 1
    assert cluster_store.finish("a2", 1, FitStatus.SUCCESSFUL, b"{}", None)
    add(cluster_store, fit("a3", client="a", cost=0.1))
    assert queues(database)["a3"] == "short"


def test_a_fit_that_runs_again_keeps_its_place(cluster_store: SqlFits, database: Engine) -> None:
    add(cluster_store, fit("first", client="a", cost=50.0))
    add(cluster_store, fit("second", client="a", cost=50.0))
    with database.begin() as connection:
        connection.execute(text("UPDATE procrastinate_jobs SET status = 'failed'"))
        connection.execute(text("UPDATE fits SET touched = now() - interval '1 hour'"))
    add(cluster_store, fit("third", client="a", cost=50.0))
    assert cluster_store.requeue_lost(60.0) == 2
    assert line(database) == ["first", "second", "third"]


def test_places_begin_anew_when_there_is_nothing_to_do(cluster_store: SqlFits, database: Engine) -> None:
    add(cluster_store, fit("a", client="a", cost=1e9))
    add(cluster_store, fit("b", client="a", cost=1e9))
    add(cluster_store, fit("c", client="a", cost=1e9))
    add(cluster_store, fit("d", client="a", cost=1e9))
    with database.connect() as connection:
        lowest = connection.execute(text("SELECT min(priority) FROM procrastinate_jobs")).scalar_one()
    assert lowest == -LAST_PLACE
    assert [serve(cluster_store, database) for _ in range(4)] == ["a", "b", "c", "d"]
    add(cluster_store, fit("e", client="a", cost=1.0))
    add(cluster_store, fit("f", client="a", cost=1.0))
    with database.connect() as connection:
        places = connection.execute(text("SELECT place FROM fits WHERE id IN ('e', 'f') ORDER BY id")).scalars().all()
    assert list(places) == [0, 1]


def test_clients_are_forgotten_when_their_next_turn_is_now(cluster_store: SqlFits, database: Engine) -> None:
    def known() -> set[str]:
        cluster_store.forget_past()
        with database.connect() as connection:
            return set(connection.execute(turns.select()).scalars())

    for number in range(3):
        add(cluster_store, fit(f"a{number}", client="a", cost=5.0))
    add(cluster_store, fit("b", client="b", cost=8.0))
    assert known() == {"a", "b"}
    for _ in range(3):
        serve(cluster_store, database)  # a0, b, a1: the next is a2, whose turn is 10
    assert known() == {"a"}
    serve(cluster_store, database)
    assert known() == set()


@pytest.fixture
def cluster(tmp_path: Path, postgres: Postgres) -> Iterator[Cluster]:
    made = Cluster(tmp_path, postgres)
    yield made
    made.end()


def test_a_worker_takes_the_fit_of_another_client_before_the_rest_of_one(cluster: Cluster) -> None:
    server = cluster.serve(FORWARDED_ALLOW_IPS="*")
    cluster.work()
    many = [server.fit(npy(torus(20_000)), SOME_SECONDS, "respond-async") for _ in range(6)]
    client = server.client
    headers = {"Content-Type": "application/x-npy", "Prefer": "wait=60", "X-Forwarded-For": "203.0.113.7"}
    assert client.post("/v1/fits", content=npy(ellipse()), headers=headers).json()["status"] == "successful"
    assert server.look(many[-1])["status"] == "accepted"
