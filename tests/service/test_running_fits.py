"""Fits on a server whose workers are killed, with real kills."""

import os
import signal
from collections.abc import Callable, Iterator
from functools import partial

import pytest

from tests.service.bodies import HALF_A_MINUTE, LONG, SOME_SECONDS, ellipse, npy, torus
from tests.service.running import Server, alive, parent, until


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Start a server whose workers are killed."""
    server = Server(tmp_path_factory.mktemp("server") / "data")
    yield server
    server.stop()


def gone(pid: int) -> bool:
    return not alive(pid)


def kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)


def test_a_killed_worker_repeats_its_fit_and_no_other(own: Server) -> None:
    fits = [own.fit(LONG, SOME_SECONDS, "respond-async") for _ in range(2)]
    before = [own.under_way(fit) for fit in fits]
    victim = until(own.busy)[0]
    kill(victim)
    after = [own.look(fit, wait=60) for fit in fits]
    assert [fit["status"] for fit in after] == ["successful"] * 2
    repeated = [was["started"] != now["started"] for was, now in zip(before, after, strict=True)]
    assert sorted(repeated) == [False, True]
    assert victim not in own.workers()
    assert own.fit(npy(ellipse()))["status"] == "successful"


def test_a_fit_that_kills_its_workers_fails_and_the_next_succeeds(own: Server) -> None:
    fit = own.fit(LONG, HALF_A_MINUTE, "respond-async")
    for _ in range(2):
        own.under_way(fit, degree=7)
        (victim,) = until(own.busy)
        kill(victim)
        until(partial(gone, victim))
        until(lambda: len(own.look(fit).get("progress", [])) < 7)  # it starts anew, or has failed
    ended = own.look(fit, wait=10)
    assert ended["status"] == "failed"
    assert ended["problem"]["type"] == "/problems/worker-crashed"
    assert own.fit(npy(ellipse()))["status"] == "successful"


def test_idle_workers_may_be_killed_too(own: Server) -> None:
    for pid in own.workers():
        kill(pid)
    assert [own.fit(npy(ellipse()))["status"] for _ in range(3)] == ["successful"] * 3
    fit = own.fit(npy(ellipse()))
    assert own.client.get(f"/v1/fits/{fit['id']}/mesh").status_code == 200


def test_dismissing_a_running_fit_kills_its_worker_and_frees_the_slot(own: Server) -> None:
    fits = [own.fit(LONG, HALF_A_MINUTE, "respond-async") for _ in range(3)]
    for fit in fits[:2]:
        own.under_way(fit)
    victims = until(lambda: pids if len(pids := own.busy()) == 2 else [])
    assert own.look(fits[2])["status"] == "accepted"
    for fit in fits:
        answer = own.client.delete(f"/v1/fits/{fit['id']}")
        assert (answer.status_code, answer.json()["status"]) == (200, "dismissed")
        assert own.client.get(f"/v1/fits/{fit['id']}/mesh").status_code == 409
    assert own.fit(npy(ellipse()))["status"] == "successful"
    until(lambda: not any(alive(pid) for pid in victims))
    assert [own.look(fit)["status"] for fit in fits] == ["dismissed"] * 3


def test_a_new_fork_server_takes_over_from_a_dead_one(own: Server) -> None:
    for pid in {parent(worker) for worker in own.workers()}:
        kill(pid)
    until(lambda: not own.workers())
    assert [own.fit(npy(ellipse()))["status"] for _ in range(3)] == ["successful"] * 3
    assert own.workers()


def test_progress_grows_while_a_fit_runs(own: Server) -> None:
    fit = own.fit(LONG, HALF_A_MINUTE, "respond-async")
    first = own.under_way(fit, degree=1)
    later = own.under_way(fit, degree=4)
    assert later["progress"][: len(first["progress"])] == first["progress"]
    assert [step["degree"] for step in later["progress"]] == list(range(1, len(later["progress"]) + 1))
    own.client.delete(f"/v1/fits/{fit['id']}")


def test_a_fit_over_its_memory_fails_and_the_server_goes_on(start: Callable[..., Server]) -> None:
    server = start(WORKERS=1, WORKER_MEMORY=2**29, MAX_POINTS=200_000)
    fit = server.fit(npy(torus(100_000)), "t1=0&max_degree=12&factor=block")  # which holds its system
    assert (fit["status"], fit["problem"]["type"]) == ("failed", "/problems/out-of-memory"), fit
    assert server.fit(npy(ellipse()))["status"] == "successful"
    server.stop()


def test_the_lane_of_short_fits_has_workers_of_the_servers_priority(start: Callable[..., Server]) -> None:
    server = start(WORKERS=1, SHORT_WORKERS=1, MESH_WORKERS=1)

    def niceness(pid: int) -> int:
        return os.getpriority(os.PRIO_PROCESS, pid) - os.getpriority(os.PRIO_PROCESS, server.process.pid)

    assert sorted(map(niceness, server.workers())) == [0, 10, 10, 10]  # two for fits, one for uploads, one for meshes
    long = server.under_way(server.fit(LONG, HALF_A_MINUTE, "respond-async"))
    (busy,) = until(server.busy)
    assert niceness(busy) == 10
    assert server.fit(npy(ellipse()))["status"] == "successful"  # in the other lane: this one is taken
    server.client.delete(f"/v1/fits/{long['id']}")
    server.stop()
