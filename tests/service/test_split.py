"""Fits in parts, on one server and on a cluster: the result is that of the whole, whichever process is killed."""

import os
import signal
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import psycopg
import pytest

import ipcore
from tests.service.bodies import Array, huge_torus, npy, sphere, torus
from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.running import Program, Server, alive, until

# Four parts, each of which takes more than half a second, and a rest that takes about as long.
SPLIT = {"SPLIT_POINTS": 100_000, "WORKERS": 1}
FIVE_LAYERS = "constraints=5l"
LINEAR = "geometric=false&t1=0&max_degree=8"


@cache
def huge() -> bytes:
    return npy(huge_torus(400_000))


class Site:
    """Servers and workers of either engine, as far as these tests can tell them apart."""

    def __init__(self, start: Callable[..., Server], cluster: Cluster | None) -> None:
        self._start, self.cluster = start, cluster
        self.server: Server
        self.workers: list[Program] = []

    def up(self, workers: int = 1, **settings: object) -> Server:
        """Start a server, and what runs its fits."""
        if self.cluster is None:
            self.server = self._start(**(SPLIT | settings))
            self.workers = [self.server]
        else:
            self.server = self.cluster.serve(**(SPLIT | settings))
            self.workers = [self.cluster.work(**(SPLIT | settings)) for _ in range(workers)]
            self.cluster.await_workers()  # a process that still loads its modules is busy, too, but with no part
        return self.server

    def again(self) -> Server:
        """Kill everything that runs fits, and start it anew."""
        for one in self.workers:
            one.kill()
        if self.cluster is None:
            return self.up()
        self.workers = [self.cluster.work(**SPLIT)]
        return self.server

    def parts(self) -> list[str]:
        """Return the states of all parts that are stored."""
        query = "SELECT status FROM fits WHERE whole IS NOT NULL ORDER BY id"
        if self.cluster is not None:
            with psycopg.connect(self.cluster.database) as connection:
                return [row[0] for row in connection.execute(query)]
        with closing(sqlite3.connect(self.server.folder / "fits.sqlite")) as connection:
            return [row[0] for row in connection.execute(query)]

    def victim(self) -> int:
        """Return a process that works on a part."""
        return until(lambda: [pid for one in self.workers for pid in one.busy(0.1)])[0]

    def victims(self) -> list[int]:
        """Return the processes that work on parts, when two are found at the same time."""
        found = [pid for one in self.workers for pid in one.busy(0.2)]
        return found if len(found) > 1 else []


@pytest.fixture(params=["embedded", "cluster"])
def site(request: pytest.FixtureRequest, start: Callable[..., Server], tmp_path: Path) -> Iterator[Site]:
    if request.param == "embedded":
        yield Site(start, None)
        return
    cluster = Cluster(tmp_path, request.getfixturevalue("postgres"))
    yield Site(start, cluster)
    cluster.end()


def summed(server: Server, fit: dict[str, Any], least: int) -> dict[str, Any]:
    """Return the fit when so many parts have ended, and it has not."""

    def far_enough() -> dict[str, Any]:
        now = server.look(fit)
        assert now["status"] in {"accepted", "running"}, now
        return now if now["parts"]["summed"] >= least else {}

    return until(far_enough)


def assert_same(fit: dict[str, Any], whole: dict[str, Any], points: Array) -> None:
    assert [one["status"] for one in (fit, whole)] == ["successful"] * 2, (fit, whole)
    for name in ("degree", "frame", "bounds"):
        assert fit["polynomial"][name] == whole["polynomial"][name]
    for name in ("stop_reason", "warnings", "options", "engine"):
        assert fit[name] == whole[name]
    for one, other in zip([*fit["steps"], fit["diagnostics"]], [*whole["steps"], whole["diagnostics"]], strict=True):
        assert one["d_dist"] == pytest.approx(other["d_dist"], rel=1e-9, abs=1e-12)
    f, g = (ipcore.ImplicitPolynomial.from_dict(one["polynomial"]) for one in (fit, whole))
    np.testing.assert_allclose(f(points), g(points), atol=1e-8)


@pytest.mark.parametrize("query", [LINEAR, "constraints=5l", "criterion=gcv&max_degree=6", "ridge=full&max_degree=6"])
def test_the_answer_is_that_of_the_whole(start: Callable[..., Server], shared: Server, query: str) -> None:
    server, table = start(SPLIT_POINTS=1000), torus(4500)
    fit = server.fit(npy(table), query, "respond-async")
    assert fit["parts"]["total"] == 5
    now = server.look(fit, wait=60)
    assert "parts" not in now
    assert_same(now, shared.fit(npy(table), query), table[:, :3])
    server.stop()


def test_what_is_no_matter_of_sums_is_not_split(start: Callable[..., Server]) -> None:
    server, table = start(SPLIT_POINTS=1000), sphere(1001)
    flat = np.hstack([table[:, :2], np.zeros((1001, 1)), np.zeros((1001, 2)), np.ones((1001, 1))])
    for content, query in (
        (table, "max_degree=2"),
        (table[:1000], LINEAR),
        (table[:, :3], LINEAR),
        (flat, LINEAR),
        (table, "factor=block&max_degree=2"),
        (table, "constraints=taubin&max_degree=2"),
        (table, "criterion=loo&max_degree=2"),
    ):
        fit = server.fit(npy(content), query, "respond-async")
        assert "parts" not in fit, query
        assert server.look(fit, wait=60)["status"] == "successful"
    server.stop()


def test_a_killed_worker_process_costs_its_part_one_try_and_the_second_the_fit(site: Site) -> None:
    server = site.up()
    fit = server.fit(huge(), FIVE_LAYERS, "respond-async")
    os.kill(site.victim(), signal.SIGKILL)
    assert server.look(fit, wait=60)["status"] == "successful"
    fit = server.fit(huge(), FIVE_LAYERS + "&max_degree=13", "respond-async")

    def struck() -> dict[str, Any]:  # whichever part is next, one of them is soon struck for the second time
        for pid in (pid for one in site.workers for pid in one.busy(0.1)):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        now = server.look(fit)
        return now if now["status"] not in {"accepted", "running"} else {}

    ended = until(struck)
    assert ended["status"] == "failed", ended
    assert ended["problem"]["type"] == "/problems/worker-crashed", ended
    assert site.parts() == []
    assert server.fit(npy(sphere()))["status"] == "successful"


def test_what_was_summed_outlives_whoever_ran_it(site: Site) -> None:
    server = site.up()
    fit = server.fit(huge(), FIVE_LAYERS, "respond-async")
    assert summed(server, fit, 1)["parts"]["summed"] < 4
    server = site.again()
    assert summed(server, fit, 1)["status"] == "running"
    summed(server, fit, 4)  # in the rest, or before it
    server = site.again()
    assert server.look(fit)["parts"] == {"summed": 4, "total": 4}
    assert server.look(fit, wait=60)["status"] == "successful"
    assert site.parts() == []


def test_dismissed_its_parts_are_killed_and_gone_at_once(site: Site) -> None:
    server = site.up(workers=2, WORKERS=2)
    fit = server.fit(huge(), FIVE_LAYERS + "&criterion=none&max_degree=16", "respond-async")
    victims = until(site.victims)
    began = time.monotonic()
    assert server.client.delete(f"/v1/fits/{fit['id']}").json()["status"] == "dismissed"
    assert site.parts() == []
    until(lambda: not any(alive(pid) for pid in victims))
    assert time.monotonic() - began < 2.0  # a second, and one more for a busy machine
    assert server.fit(npy(sphere()))["status"] == "successful"
    assert server.look(fit)["status"] == "dismissed"


def test_a_part_that_fails_fails_the_fit(site: Site) -> None:
    server = site.up(FIT_DEADLINE=0.3)
    fit = server.fit(huge(), FIVE_LAYERS)
    assert fit["problem"]["type"] == "/problems/deadline-exceeded", fit
    assert site.parts() == []


def test_two_machines_share_the_parts_of_a_fit(tmp_path: Path, postgres: Postgres) -> None:
    cluster = Cluster(tmp_path, postgres, **SPLIT)
    try:
        server, (first, second) = cluster.serve(), (cluster.work(), cluster.work())
        fit = server.fit(huge(), FIVE_LAYERS, "respond-async")
        until(lambda: len(cluster.holders()) == 2)
        first.kill()
        split = server.look(fit, wait=60)
        second.kill()
        cluster.work(SPLIT_POINTS=10**6)
        whole = cluster.serve(SPLIT_POINTS=10**6).fit(huge(), FIVE_LAYERS)
        assert_same(split, whole, huge_torus(1000)[:, :3])
    finally:
        cluster.end()
