"""Two replicas of the API and two workers around one PostgreSQL, each of which is killed."""

import os
import signal
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.service.bodies import HALF_A_MINUTE, LONG, SOME_SECONDS, ellipse, npy
from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.running import Server, Worker, alive, until

NPY = {"Content-Type": "application/x-npy"}


@pytest.fixture
def cluster(tmp_path: Path, postgres: Postgres) -> Iterator[Cluster]:
    made = Cluster(tmp_path, postgres)
    yield made
    made.end()


@pytest.fixture
def own_postgres() -> Iterator[Postgres]:
    """Start a PostgreSQL that is killed."""
    server = Postgres()
    yield server
    server.remove()


def refused(server: Server) -> bool:
    answer = server.client.post("/v1/fits", content=npy(ellipse()), headers=NPY)
    return answer.status_code == 503 and answer.json()["type"] == "/problems/not-ready"


def idempotent(server: Server, key: str) -> dict[str, Any]:
    answer = server.client.post("/v1/fits", content=npy(ellipse()), headers=NPY | {"Idempotency-Key": f'"{key}"'})
    fit: dict[str, Any] = answer.json()
    return fit


def test_replicas_and_workers_answer_for_each_others_fits(cluster: Cluster) -> None:
    servers = [cluster.serve(), cluster.serve()]
    workers = [cluster.work(), cluster.work()]
    long = [server.fit(LONG, HALF_A_MINUTE, "respond-async") for server in servers]
    for server, fit in zip(reversed(servers), long, strict=True):
        assert server.under_way(fit)["progress"][0]["degree"] == 1
    assert len(cluster.holders()) == 2
    for server, fit in zip(reversed(servers), long, strict=True):
        assert server.client.delete(f"/v1/fits/{fit['id']}").json()["status"] == "dismissed"
    fits = [server.fit(npy(ellipse()), prefer="respond-async") for server in servers]
    for server, fit in zip(reversed(servers), fits, strict=True):
        assert server.look(fit, wait=60)["status"] == "successful"
        assert server.client.get(f"/v1/fits/{fit['id']}/mesh").status_code == 200
    assert idempotent(servers[0], "k")["id"] == idempotent(servers[1], "k")["id"]
    for worker in workers:
        worker.stop()
    for server in servers:
        server.stop()


def test_who_waits_hears_of_the_end_at_once(cluster: Cluster) -> None:
    server, _ = cluster.serve(), cluster.work()
    server.fit(npy(ellipse()))
    began = time.monotonic()
    for _ in range(5):
        assert server.fit(npy(ellipse()))["status"] == "successful"
    assert time.monotonic() - began < 5.0  # looking every two seconds would take longer


def test_a_cancel_reaches_a_worker_from_any_replica_and_frees_its_seat_at_once(cluster: Cluster) -> None:
    servers, worker = [cluster.serve(), cluster.serve()], cluster.work()
    fit = servers[0].fit(LONG, HALF_A_MINUTE, "respond-async")
    servers[0].under_way(fit, degree=6)
    (victim,) = until(worker.busy)
    waiting = servers[1].fit(LONG, "geometric=false&max_degree=3", "respond-async")
    began = time.monotonic()
    assert servers[1].client.delete(f"/v1/fits/{fit['id']}").json()["status"] == "dismissed"
    until(lambda: not alive(victim))
    until(lambda: servers[0].look(waiting)["status"] != "accepted")
    assert time.monotonic() - began < 2.0
    assert servers[0].look(waiting, wait=30)["status"] == "successful"
    assert servers[0].look(fit)["status"] == "dismissed"


def test_the_fits_of_a_killed_worker_are_run_by_another(cluster: Cluster) -> None:
    server, first = cluster.serve(), cluster.work()
    fit = server.fit(LONG, SOME_SECONDS, "respond-async")
    server.under_way(fit)
    first.kill()
    cluster.work()
    assert server.look(fit, wait=60)["status"] == "successful"


def test_a_worker_that_is_stopped_gives_its_fits_back_at_once(cluster: Cluster) -> None:
    server, first = cluster.serve(), cluster.work(LEASE=600)
    fit = server.fit(LONG, SOME_SECONDS, "respond-async")
    server.under_way(fit)
    first.stop()
    assert server.look(fit)["status"] == "accepted"
    cluster.work(LEASE=600)
    assert server.look(fit, wait=60)["status"] == "successful"


def test_a_worker_ends_what_it_runs_when_it_has_the_time_and_at_a_second_signal_does_not(cluster: Cluster) -> None:
    server, patient = cluster.serve(), cluster.work(SHUTDOWN_GRACE=60)
    fit = server.fit(LONG, SOME_SECONDS, "respond-async")
    server.under_way(fit)
    patient.stop(60.0)
    assert server.look(fit)["status"] == "successful"

    hurried = cluster.work(SHUTDOWN_GRACE=600)
    fit = server.fit(LONG, HALF_A_MINUTE, "respond-async")
    server.under_way(fit)
    hurried.process.send_signal(signal.SIGTERM)
    time.sleep(0.5)
    assert hurried.process.poll() is None
    hurried.stop(5.0)
    assert server.look(fit)["status"] == "accepted"


def test_a_fit_that_kills_its_worker_processes_fails_and_the_next_succeeds(cluster: Cluster) -> None:
    server, worker = cluster.serve(), cluster.work()
    fit = server.fit(LONG, HALF_A_MINUTE, "respond-async")
    for _ in range(2):
        server.under_way(fit)
        (victim,) = until(worker.busy)
        os.kill(victim, signal.SIGKILL)
        until(partial(lambda pid: not alive(pid), victim))
        until(lambda: not server.look(fit).get("progress"))  # it starts anew, or has failed
    assert server.look(fit, wait=10)["problem"]["type"] == "/problems/worker-crashed"
    assert server.fit(npy(ellipse()))["status"] == "successful"


def test_a_database_that_is_down_is_503_and_loses_nothing(tmp_path: Path, own_postgres: Postgres) -> None:
    cluster = Cluster(tmp_path, own_postgres)
    try:
        server, _ = cluster.serve(), cluster.work()
        running = server.fit(LONG, SOME_SECONDS, "respond-async")
        waiting = server.fit(LONG, "t1=0&max_degree=4", "respond-async")
        server.under_way(running)
        own_postgres.kill()
        until(lambda: refused(server))
        for answer in (server.client.get("/readyz"), server.client.get(f"/v1/fits/{running['id']}")):
            assert answer.status_code == 503
            assert "Retry-After" in answer.headers
        assert server.client.get("/livez").is_success
        time.sleep(3.0)  # longer than the fit takes, and than its lease
        own_postgres.start()
        assert until(lambda: server.client.get("/readyz").is_success)
        assert [server.look(fit, wait=60)["status"] for fit in (running, waiting)] == ["successful"] * 2
        assert server.fit(npy(ellipse()))["status"] == "successful"
    finally:
        cluster.end()


def test_cut_connections_lose_nothing(cluster: Cluster, postgres: Postgres) -> None:
    server, _ = cluster.serve(), cluster.work()
    fit = server.fit(LONG, SOME_SECONDS, "respond-async")
    server.under_way(fit)
    assert postgres.cut() > 2
    assert server.look(fit, wait=60)["status"] == "successful"
    assert server.fit(npy(ellipse()))["status"] == "successful"


def test_a_worker_without_a_database_says_so(tmp_path: Path) -> None:
    worker = Worker(tmp_path / "data")
    assert worker.process.wait(30.0) == 2
    assert "IPFIT_DATABASE_URL" in worker.log
