"""What a server tells Prometheus, and whether it is ready: by real fits, in real processes."""

import asyncio
import os
import signal
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from prometheus_client.openmetrics import parser as openmetrics
from prometheus_client.parser import text_string_to_metric_families

from service.jobs.errors import NotReadyError
from service.problem_types import PROBLEM_TYPES
from service.workers.canary import Canary
from service.workers.pool import WorkerPool
from tests.service.bodies import HALF_A_MINUTE, LONG, ellipse, npy
from tests.service.clusters import Cluster
from tests.service.conftest import Start
from tests.service.postgres import Postgres
from tests.service.running import LISTENING, until
from tests.service.test_api_keys import bearer
from tests.service.test_problems import problem

OPEN_METRICS = "application/openmetrics-text;version=1.0.0;q=0.6,text/plain;version=0.0.4;q=0.3,*/*;q=0.2"
Samples = dict[tuple[str, frozenset[tuple[str, str]]], float]


def samples(text: str) -> Samples:
    families = text_string_to_metric_families(text)
    return {(one.name, frozenset(one.labels.items())): one.value for family in families for one in family.samples}


def value(found: Samples, name: str, **labels: str) -> float:
    """Return the sum of the samples of this name that have these labels."""
    return sum(number for (other, own), number in found.items() if other == name and labels.items() <= own)


def measured(client: httpx.Client) -> Samples:
    return samples(client.get("/metrics").text)


def test_requests_fits_queue_workers_and_memory_are_measured(start: Start) -> None:
    server = start(WORKERS=1, SHORT_WORKERS=0)
    done = server.fit(npy(ellipse(50)))
    running, waiting = (server.fit(LONG, HALF_A_MINUTE, "respond-async") for _ in range(2))
    server.under_way(running, degree=1)
    assert server.client.get(f"/v1/fits/{'0' * 32}").status_code == 404
    assert server.client.get("/no/such/path").status_code == 404
    assert server.client.head(f"/v1/fits/{done['id']}").is_success
    found = measured(server.client)
    assert value(found, "ipfit_http_requests_total", route="/v1/fits", method="POST", status="200") == 1
    assert value(found, "ipfit_http_requests_total", route="/v1/fits", method="POST", status="202") == 2
    assert value(found, "ipfit_http_requests_total", route="/v1/fits/{fit_id}", status="404") == 1
    assert value(found, "ipfit_http_requests_total", route="none", status="404") == 1
    assert value(found, "ipfit_http_requests_total", route="/v1/fits/{fit_id}", method="HEAD") == 1
    assert value(found, "ipfit_http_request_seconds_count", route="/v1/fits") == 3
    assert value(found, "ipfit_http_phase_seconds_count", phase="store") == 3
    assert value(found, "ipfit_http_phase_seconds_sum", phase="wait") > 0.0
    reason = {"dimension": "2d", "status": "successful", "stop_reason": done["stop_reason"]}
    assert value(found, "ipfit_fits_total", **reason) == value(found, "ipfit_fits_total") == 1
    assert value(found, "ipfit_fit_points_sum", dimension="2d") == 50
    assert value(found, "ipfit_fit_degree_sum", dimension="2d") == done["polynomial"]["degree"]
    assert 0.0 < value(found, "ipfit_fit_seconds_sum") < 30.0
    assert value(found, "ipfit_queue_wait_seconds_count", lane="short") == 1
    assert value(found, "ipfit_queue_fits", lane="long", state="running") == 1
    assert value(found, "ipfit_queue_fits", lane="long", state="waiting") == 1
    assert value(found, "ipfit_queue_oldest_seconds", lane="long") > 0.0
    assert value(found, "ipfit_workers", pool="fits", state="busy") == 1
    assert value(found, "ipfit_workers", pool="uploads", state="idle") == 1
    assert 1e7 < value(found, "ipfit_memory_bytes", process="main") < 1e9
    assert 1e7 < value(found, "ipfit_memory_bytes", process="workers") < 1e10
    assert server.client.delete(f"/v1/fits/{waiting['id']}").is_success


def test_a_worker_that_dies_is_counted(start: Start) -> None:
    server = start(WORKERS=1)
    server.under_way(server.fit(LONG, HALF_A_MINUTE, "respond-async"))
    (busy,) = until(server.busy)
    os.kill(busy, signal.SIGKILL)
    until(lambda: value(measured(server.client), "ipfit_worker_deaths_total", pool="fits") == 1)


def test_what_is_refused_before_it_is_read_is_counted(start: Start) -> None:
    server = start(WORKERS=1, SHORT_WORKERS=0)
    before = measured(server.client)
    assert value(before, "ipfit_connections") >= 1
    assert value(before, "ipfit_refused_requests_total") == 0
    for head in (b"GET / HTTP/1.1\r\nno colon\r\n\r\n", b"GET / HTTP/1.1\r\nX: " + b"x" * 70_000 + b"\r\n\r\n"):
        with socket.create_connection((server.client.base_url.host, server.client.base_url.port or 0)) as connection:
            connection.sendall(head)
            assert connection.recv(4096).startswith(b"HTTP/1.1 4")
    until(lambda: value(measured(server.client), "ipfit_refused_requests_total") == 2)
    found = measured(server.client)
    codes = {dict(labels)["code"] for name, labels in found if name == "ipfit_refused_requests_total"}
    assert codes <= set(PROBLEM_TYPES)
    assert len(codes) == 2


def test_prometheus_gets_the_format_that_it_asks_for(client: httpx.Client) -> None:
    answer = client.get("/metrics", headers={"Accept": OPEN_METRICS})
    assert answer.headers["Content-Type"] == "application/openmetrics-text; version=1.0.0; charset=utf-8"
    found = openmetrics.text_string_to_metric_families(answer.text)  # type: ignore[no-untyped-call] # of the package
    names = {family.name for family in found}
    assert {"ipfit_http_requests", "ipfit_workers", "process_cpu_seconds"} <= names
    answer = client.get("/metrics", headers={"Accept": "nonsense;;;,application/openmetrics-text;version=1.x;q=0"})
    assert answer.headers["Content-Type"] == "text/plain; version=0.0.4; charset=utf-8"
    assert samples(answer.text)


def test_labels_do_not_grow_with_what_callers_send(client: httpx.Client) -> None:
    before = {own for name, own in measured(client) if name == "ipfit_http_requests_total"}
    for i in range(5):
        client.request(f"ODD{i}", f"/odd/{i}")
        client.get(f"/v1/fits/odd{i}")
    after = {own for name, own in measured(client) if name == "ipfit_http_requests_total"}
    assert len(after - before) <= 4


def test_where_there_are_keys_metrics_want_one(start: Start, keys: tuple[Path, str, str]) -> None:
    file, ada, _ = keys
    server = start(API_KEYS=file, WORKERS=1)
    problem(server.client.get("/metrics"), 401, "unauthorized")
    assert server.client.get("/metrics", headers=bearer(ada)).is_success


@pytest.fixture
def cluster(tmp_path: Path, postgres: Postgres) -> Iterator[Cluster]:
    made = Cluster(tmp_path, postgres)
    yield made
    made.end()


def test_a_worker_of_a_cluster_has_probes_of_its_own(cluster: Cluster) -> None:
    worker, server = cluster.work(PROBE_PORT=0), cluster.serve()
    (listening,) = LISTENING.findall(until(lambda: worker.log if "Uvicorn running" in worker.log else ""))
    with httpx.Client(base_url=listening) as probes:
        until(lambda: probes.get("/readyz").is_success)
        server.fit(npy(ellipse(50)))
        assert probes.get("/livez").json() == {"status": "ok"}
        assert value(measured(probes), "ipfit_fits_total", status="successful") == 1
        assert value(measured(probes), "ipfit_workers", pool="fits") == 1
        assert value(measured(server.client), "ipfit_fits_total") == 0
        found = measured(server.client)
        assert [one for one in found if one[0] == "ipfit_queue_fits"], "the store was asked"
        assert value(found, "ipfit_queue_fits") == 0
        problem(probes.get("/v1/fits"), 404, "not-found")
    worker.stop()


def test_a_server_whose_workers_cannot_fit_is_not_ready() -> None:
    async def script() -> None:
        pool = WorkerPool(1, 10, memory=2**20)  # too little for anything
        canary = Canary([pool])
        assert "no fit was tried" in fault(canary)
        await canary.try_now()
        assert "Error" in fault(canary)
        await asyncio.to_thread(pool.close)

    asyncio.run(script())


def fault(canary: Canary) -> str:
    with pytest.raises(NotReadyError) as caught:
        canary.check()
    return str(caught.value)


def test_a_server_is_ready_when_its_workers_have_fitted_and_while_all_of_them_fit() -> None:
    async def script() -> None:
        pool = WorkerPool(1, 10, memory=2**31)
        canary = Canary([pool])
        await canary.try_now()
        canary.check()
        busy = asyncio.create_task(pool.run(time.sleep, 60.0))
        await asyncio.sleep(0.0)
        assert pool.busy == 1
        async with asyncio.timeout(5.0):
            await canary.try_now()
        canary.check()
        busy.cancel()
        await asyncio.gather(busy, return_exceptions=True)
        await asyncio.to_thread(pool.close)

    asyncio.run(script())
