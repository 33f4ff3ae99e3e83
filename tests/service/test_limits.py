"""Requests over a limit are refused before they are received, and the server answers others meanwhile."""

import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import httpx
import pytest

import ipcore
from service.api.limits import Limits
from service.jobs.errors import InvalidInputError, TooLargeError
from service.jobs.fit import ReceivedPoints
from service.jobs.point_set_summary import PointSetSummary
from service.jobs.requested_options import RequestedOptions
from service.jobs.slices import Frame
from service.workers.planner_adapter import FitPlanner
from tests.service.bodies import HALF_A_MINUTE, ellipse, npy, torus
from tests.service.running import Server

MIB = 2**20
NPY = {"Content-Type": "application/x-npy"}
SUMMARY = PointSetSummary(planar=False, frame=Frame((0.0, 0.0, 0.0), 1.0), sha256="")
LIMITS = Limits(MIB, {2: 10, 3: 6}, {2: 100, 3: 50}, 10_000_000, 10.0)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Start a server that takes little, and gives a fit half a second."""
    server = Server(
        tmp_path_factory.mktemp("small") / "data",
        WORKERS=1,
        MAX_BODY_BYTES=MIB,
        MAX_POINTS=10_000,
        MAX_DEGREE_3D=12,
        MAX_SYSTEM_BYTES=100 * MIB,
        MAX_WAIT=1,
        FIT_DEADLINE=1.5,
    )
    yield server
    server.stop()


def point_set(points: int) -> ReceivedPoints:
    return ReceivedPoints(b"", "", 3, points, normals=True, options={}, summary=SUMMARY)


@pytest.mark.parametrize(("dimension", "highest"), [(2, 10), (3, 6)])
def test_a_degree_over_the_limit_is_refused(dimension: int, highest: int) -> None:
    given = RequestedOptions({"max_degree": highest})
    assert LIMITS.capped(dimension, given) is given
    with pytest.raises(InvalidInputError, match=f"at most {highest}"):
        LIMITS.capped(dimension, given.with_max_degree(highest + 1))


def test_a_limit_below_the_default_degree_becomes_the_default() -> None:
    assert LIMITS.capped(3, RequestedOptions({"t1": 0.1})).given == {"t1": 0.1, "max_degree": 6}


def test_a_system_over_the_limit_is_refused() -> None:
    columns = 84  # of degree 6 in 3D
    most = 10_000_000 // (24 * columns)

    def check(points: int, **options: Any) -> None:  # noqa: ANN401 - any
        given = point_set(points)
        LIMITS.check_system(given, FitPlanner().plan(given, ipcore.FitOptions.of(**({"max_degree": 6} | options))))

    check(most, factor="block")
    with pytest.raises(TooLargeError, match="lower max_degree, send fewer points, or take factor auto"):
        check(most + 1, factor="block")
    check(most + 1, factor="block", max_degree=5)
    check(most + 1)  # which holds none


def test_options_that_the_dimension_does_not_allow_are_named() -> None:
    with pytest.raises(InvalidInputError, match="at most 20 for 3D points") as refused:
        FitPlanner().plan(point_set(9), ipcore.FitOptions(max_degree=21))
    assert refused.value.at == ("options", "max_degree")


def test_a_resolution_over_the_limit_is_refused() -> None:
    for resolution in (None, 50):
        LIMITS.check_resolution(resolution, 3)
    with pytest.raises(InvalidInputError, match="at most 50"):
        LIMITS.check_resolution(51, 3)


def test_too_many_points_and_too_large_a_system_are_413(small: Server) -> None:
    for content, query in ((npy(torus(10_001)), ""), (npy(torus(10_000)), "max_degree=12&factor=block")):
        answer = small.client.post(f"/v1/fits?{query}", content=content, headers=NPY)
        assert (answer.status_code, answer.json()["type"]) == (413, "/problems/too-large")


def test_the_servers_own_degree_limit_is_named(small: Server) -> None:
    answer = small.client.post("/v1/fits?max_degree=13", content=npy(torus()), headers=NPY)
    assert (answer.status_code, answer.json()["errors"][0]["parameter"]) == (422, "max_degree")


def test_a_fit_over_its_deadline_fails_and_the_next_one_runs(small: Server) -> None:
    fit = small.fit(npy(torus(5_000)), HALF_A_MINUTE.replace("16", "12"), "respond-async")
    for _ in range(20):
        fit = small.look(fit, wait=1)
        if fit["status"] not in ("accepted", "running"):
            break
    assert fit["status"] == "failed"
    assert fit["problem"]["type"] == "/problems/deadline-exceeded"
    assert "1.5 s" in fit["problem"]["detail"]
    without = small.client.get(f"/v1/fits/{fit['id']}/mesh")
    assert (without.status_code, without.json()["type"]) == (409, "/problems/fit-without-result")
    assert small.fit(npy(ellipse()))["status"] == "successful"


def test_nobody_waits_longer_than_the_limit(small: Server) -> None:
    answer = small.client.post("/v1/fits", content=npy(ellipse()), headers=NPY | {"Prefer": "wait=999"})
    assert answer.headers["Preference-Applied"] == "wait=1"


def talk(server: Server) -> socket.socket:
    url = httpx.URL(server.url)
    return socket.create_connection((url.host, url.port or 80), timeout=10.0)


HEAD = b"POST /v1/fits HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"


def test_an_announced_body_over_the_limit_is_refused_unread(small: Server) -> None:
    with talk(small) as connection:
        connection.sendall(HEAD + b"Content-Length: 10000000000\r\n\r\n")
        assert connection.recv(1000).startswith(b"HTTP/1.1 413 ")


@pytest.mark.parametrize(("number", "status"), [(b"10000000000", b"413"), (b"2", b"422")])
def test_a_length_of_thousands_of_digits_is_read_as_any_other(small: Server, number: bytes, status: bytes) -> None:
    with talk(small) as connection:
        connection.sendall(HEAD + b"Content-Length: " + b"0" * 5000 + number + b"\r\n\r\n{}")
        assert connection.recv(1000).startswith(b"HTTP/1.1 " + status)


def test_a_chunked_body_over_the_limit_is_refused_and_not_read_to_its_end(small: Server) -> None:
    chunk = b"10000\r\n" + b" " * 0x10000 + b"\r\n"
    sent = 0
    with talk(small) as connection:
        connection.sendall(HEAD + b"Transfer-Encoding: chunked\r\n\r\n")
        with suppress(BrokenPipeError, ConnectionResetError):
            while sent < 200 * MIB:
                connection.sendall(chunk)
                sent += 0x10000
    assert sent < 20 * MIB  # what the sockets' buffers take is sent, but not read
    assert small.client.get("/livez").is_success
    assert not list((small.folder / "incoming").iterdir())


@pytest.mark.parametrize("chunked", [False, True])
def test_a_body_over_the_limit_is_413(small: Server, *, chunked: bool) -> None:
    body = b" " * (MIB + 1)
    content = iter([body[:MIB], body[MIB:]]) if chunked else body
    answer = small.client.post("/v1/fits", content=content, headers={"Content-Type": "application/json"})
    assert (answer.status_code, answer.json()["type"]) == (413, "/problems/too-large")


def test_a_body_of_just_the_limit_is_read(small: Server) -> None:
    body = json.dumps({"points": ellipse().tolist()}).encode().ljust(MIB)
    answer = small.client.post("/v1/fits", content=body, headers={"Content-Type": "application/json"})
    assert answer.json()["status"] == "successful"


def test_the_server_answers_while_50_megabytes_are_parsed(shared: Server) -> None:
    body = b'{"points": [' + b"[1.0,2.0]," * 5_200_000 + b"[1.0,2.0]]}"
    assert len(body) > 50_000_000
    answers: list[int] = []

    def send() -> None:
        headers = {"Content-Type": "application/json"}
        answers.append(httpx.post(f"{shared.url}/v1/fits", content=body, headers=headers, timeout=60.0).status_code)

    sender = threading.Thread(target=send)
    sender.start()
    slowest = 0.0
    while sender.is_alive():
        began = time.monotonic()
        assert shared.client.get("/livez").is_success
        slowest = max(slowest, time.monotonic() - began)
        time.sleep(0.01)
    assert answers == [413]  # too many points
    assert slowest < 0.5
    assert not list((shared.folder / "incoming").iterdir())
