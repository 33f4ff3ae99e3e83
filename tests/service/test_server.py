"""A server that is stopped, killed or full, or whose disk or store fails."""

import os
import resource
import signal
import sqlite3
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

import httpx

from tests.service.bodies import HALF_A_MINUTE, LONG, SOME_SECONDS, ellipse, npy
from tests.service.raw import talk
from tests.service.running import COMMAND, Server, alive, until

NPY = {"Content-Type": "application/x-npy"}


def test_a_store_that_fails_is_503(start: Callable[..., Server]) -> None:
    server = start(WORKERS=1)
    with closing(sqlite3.connect(server.folder / "fits.sqlite")) as database:
        database.execute("ALTER TABLE fits RENAME TO elsewhere")
        headers = {"Content-Type": "application/x-npy"}
        for answer in (
            server.client.get("/readyz"),
            server.client.post("/v1/fits", content=npy(ellipse()), headers=headers),
        ):
            assert (answer.status_code, answer.json()["type"]) == (503, "/problems/not-ready")
            assert "Retry-After" in answer.headers
        assert server.client.get("/livez").is_success
        database.execute("ALTER TABLE elsewhere RENAME TO fits")
    assert server.client.get("/readyz").is_success
    assert server.fit(npy(ellipse()))["status"] == "successful"


def test_no_fit_is_lost_when_the_server_is_killed_or_stopped(start: Callable[..., Server]) -> None:
    first = start(WORKERS=1)
    running = first.fit(LONG, SOME_SECONDS, "respond-async")
    waiting = first.fit(LONG, "t1=0&max_degree=5", "respond-async")
    first.under_way(running)
    assert first.look(waiting)["status"] == "accepted"
    orphans = first.workers()
    first.kill()
    until(lambda: not any(alive(pid) for pid in orphans))  # a worker does not outlive its server
    half_read = first.folder / "incoming" / "body-left"
    half_read.write_bytes(b"half a")

    second = start(WORKERS=1)
    assert not half_read.exists()
    second.under_way(running)
    with ThreadPoolExecutor() as threads:
        where = f"{second.url}/v1/fits/{running['id']}"
        patient = threads.submit(httpx.get, where, headers={"Prefer": "wait=60"}, timeout=60.0)
        time.sleep(0.3)
        began = time.monotonic()
        second.stop()
        assert time.monotonic() - began < 5.0
        assert patient.result().json()["status"] == "running"  # who waits is answered, not cut off

    third = start(WORKERS=1)
    ended = [third.look(fit, wait=60) for fit in (running, waiting)]
    assert [fit["status"] for fit in ended] == ["successful"] * 2
    third.stop()


def test_a_stopping_server_lets_fits_end_and_answers_meanwhile(start: Callable[..., Server]) -> None:
    first = start(WORKERS=1, SHUTDOWN_GRACE=30)
    running = first.fit(LONG, SOME_SECONDS, "respond-async")
    first.under_way(running)
    with ThreadPoolExecutor() as threads:
        where = f"{first.url}/v1/fits/{running['id']}"
        patient = threads.submit(httpx.get, where, headers={"Prefer": "wait=60"}, timeout=60.0)
        time.sleep(0.3)
        first.process.send_signal(signal.SIGTERM)
        until(lambda: first.client.get("/readyz").status_code == 503)
        refused = first.client.post("/v1/fits", content=npy(ellipse()), headers=NPY)
        assert (refused.status_code, refused.json()["type"]) == (503, "/problems/shutting-down")
        assert patient.result().json()["status"] == "successful"
    assert first.process.wait(10.0) == 0
    first.client.close()
    second = start(WORKERS=1)
    assert second.look(running)["status"] == "successful"
    second.stop()


def test_a_request_that_takes_longer_than_a_stopping_server_waits_is_told_so(start: Callable[..., Server]) -> None:
    first = start(WORKERS=1)
    head = b"POST /v1/fits HTTP/1.1\r\nHost: x\r\nContent-Type: application/x-npy\r\nContent-Length: 30000\r\n\r\n"
    with ThreadPoolExecutor() as threads:
        slow = threads.submit(talk, first, head, *[b"x" * 1000] * 30, pause=0.5)
        time.sleep(1.0)
        first.process.send_signal(signal.SIGTERM)
        answer = slow.result()
    assert (answer.status, answer.problem["code"]) == (503, "shutting-down")
    assert first.process.wait(10.0) == 0
    assert "Traceback" not in first.log
    first.client.close()


def test_a_second_signal_ends_a_stopping_server_at_once_and_loses_nothing(start: Callable[..., Server]) -> None:
    first = start(WORKERS=1, SHUTDOWN_GRACE=600)
    running = first.fit(LONG, SOME_SECONDS.replace("7", "12"), "respond-async")
    first.under_way(running)
    first.process.send_signal(signal.SIGTERM)
    until(lambda: first.client.get("/readyz").status_code == 503)
    assert first.process.poll() is None
    began = time.monotonic()
    first.process.send_signal(signal.SIGTERM)
    assert first.process.wait(10.0) == 0
    assert time.monotonic() - began < 2.0
    first.client.close()
    second = start(WORKERS=1)
    second.under_way(running)
    second.client.delete(f"/v1/fits/{running['id']}")
    second.stop()


def test_a_full_disk_is_503_and_accepts_nothing(start: Callable[..., Server]) -> None:
    server = start(WORKERS=1)
    kept = server.fit(npy(ellipse()))
    # No file may grow over 4 KiB: the kernel refuses the writes of the server as it does on a full disk.
    resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
    for content in (npy(ellipse(61)), npy(ellipse(1000))):
        answer = server.client.post("/v1/fits", content=content, headers=NPY)
        assert (answer.status_code, answer.json()["type"]) == (503, "/problems/not-ready"), answer.text
        assert "Retry-After" in answer.headers
    assert server.look(kept)["status"] == "successful"
    resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    with closing(sqlite3.connect(server.folder / "fits.sqlite")) as database:
        assert database.execute("SELECT count(*) FROM fits").fetchone() == (1,)
    assert server.fit(npy(ellipse(61)))["status"] == "successful"
    server.kill()


def test_a_full_queue_is_503_and_says_when_to_come_again(start: Callable[..., Server]) -> None:
    server = start(WORKERS=1, QUEUE_LIMIT=2, CLIENT_SHARE=1)
    fits = [server.fit(LONG, HALF_A_MINUTE, "respond-async")]
    server.under_way(fits[0], degree=1)
    fits += [server.fit(LONG, HALF_A_MINUTE, "respond-async") for _ in range(2)]
    answer = server.client.post("/v1/fits", content=npy(ellipse()), headers=NPY)
    assert (answer.status_code, answer.json()["type"]) == (503, "/problems/queue-full")
    assert int(answer.headers["Retry-After"]) >= 10
    server.client.delete(f"/v1/fits/{fits[1]['id']}")
    assert server.fit(npy(ellipse()), prefer="respond-async")["status"] == "accepted"
    server.stop()


def test_old_fits_are_removed_with_their_points(start: Callable[..., Server]) -> None:
    first = start(WORKERS=1)
    fit = first.fit(npy(ellipse()))
    first.stop()
    second = start(WORKERS=1, KEEP_SECONDS=0.001)
    until(lambda: second.client.get(f"/v1/fits/{fit['id']}").status_code == 404)
    until(lambda: not [one for one in (second.folder / "blobs").rglob("*") if one.is_file()])
    second.stop()


def test_one_folder_is_for_one_server(shared: Server) -> None:
    second = subprocess.run(  # noqa: S603 - our own command
        [COMMAND, "serve"],
        env=os.environ | {"IPFIT_PORT": "0", "IPFIT_DATA_DIR": str(shared.folder)},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert second.returncode != 0
    assert "another server uses" in second.stderr


def healthcheck(port: object) -> int:
    told = os.environ | {"IPFIT_PORT": str(port)}
    return subprocess.run([COMMAND, "healthcheck"], env=told, timeout=30.0, check=False).returncode  # noqa: S603 - ours


def test_the_health_check_tells_a_ready_server_from_none(shared: Server) -> None:
    port = httpx.URL(shared.url).port
    assert healthcheck(port) == 0
    assert healthcheck(1) == 1
