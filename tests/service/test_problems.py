"""Every error has problem details with its place and a trace id, and no request gets a 500."""

import json
import socket
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from tests.service.bodies import ellipse, npy, sphere

POINTS = ellipse(20).tolist()
JSON = {"Content-Type": "application/json"}
NPY = {"Content-Type": "application/x-npy"}


def problem(answer: httpx.Response, status: int, kind: str) -> dict[str, Any]:
    """Return the problem, which must be one from head to foot."""
    assert answer.status_code == status, answer.text
    assert answer.headers["Content-Type"] == "application/problem+json"
    told: dict[str, Any] = answer.json()
    assert (told["type"], told["code"]) == (f"/problems/{kind}", kind)
    assert told["status"] == status
    assert told["title"]
    assert told["detail"]
    assert len(told["trace_id"]) == 32
    assert len(answer.content) < 3000  # what was sent is not told back in full
    return told


def post(client: httpx.Client, body: object, query: str = "") -> httpx.Response:
    content = body if isinstance(body, bytes) else json.dumps(body).encode()
    return client.post(f"/v1/fits?{query}", content=content, headers=JSON)


@pytest.mark.parametrize(
    ("body", "pointer"),
    [
        ({}, "/points"),
        ({"points": []}, "/points"),
        ({"points": [*POINTS, [1.0, None]]}, "/points/20/1"),
        ({"points": [*POINTS, [1.0, 2.0, 3.0]]}, "/points/20"),
        ({"points": [POINTS[0]] * 20}, "/points"),
        ({"points": [[float(i), 2.0 * i, 0.0] for i in range(20)]}, "/points"),
        ({"points": POINTS, "normals": POINTS[1:]}, "/normals"),
        ({"points": POINTS, "normals": [[0.0, 0.0]] * 20}, "/normals/0"),
        ({"points": POINTS, "pionts": POINTS}, "/pionts"),
        ({"points": POINTS, "a/b~c": 1}, "/a~1b~0c"),
        ({"points": POINTS, "options": {"max_degre": 3}}, "/options/max_degre"),
        ({"points": POINTS, "options": {"max_degree": 41}}, "/options/max_degree"),
        ({"points": sphere()[:, :3].tolist(), "options": {"max_degree": 21}}, "/options/max_degree"),
        ({"points": POINTS, "options": {"max_degree": "3"}}, "/options/max_degree"),
        ({"points": POINTS, "options": {"max_degree": True}}, "/options/max_degree"),
        ({"points": POINTS, "options": {"max_degree": 0}}, "/options/max_degree"),
        ({"points": POINTS, "options": {"layer_distance": 0.0}}, "/options/layer_distance"),
        ({"points": POINTS, "options": {"basis": "bernstein"}}, "/options/basis"),
        ({"points": POINTS, "options": {"measure_zero_set": 1}}, "/options/measure_zero_set"),
        ({"points": POINTS, "options": []}, "/options"),
    ],
)
def test_the_place_in_the_body_is_told(client: httpx.Client, body: object, pointer: str) -> None:
    (fault,) = problem(post(client, body), 422, "invalid-input")["errors"]
    assert fault["pointer"] == pointer
    assert fault["detail"]


@pytest.mark.parametrize(
    ("query", "parameter"),
    [
        ("max_degree=41", "max_degree"),
        ("max_degree=three", "max_degree"),
        ("max_degree=", "max_degree"),
        ("t1=nan", "t1"),
        ("t1=inf", "t1"),
        ("t2=2", "t2"),
        ("layer_distance=-0.1", "layer_distance"),
        ("max_degre=3", "max_degre"),
        ("format=ply", "format"),
        ("basis=x", "basis"),
        ("measure_zero_set=perhaps", "measure_zero_set"),
    ],
)
def test_the_parameter_is_told(client: httpx.Client, query: str, parameter: str) -> None:
    (fault,) = problem(post(client, {"points": POINTS}, query), 422, "invalid-parameter")["errors"]
    assert fault["parameter"] == parameter


def test_a_degree_too_high_for_3d_in_the_query_is_told_as_a_parameter(client: httpx.Client) -> None:
    answer = client.post("/v1/fits?max_degree=21", content=npy(sphere()), headers=NPY)
    (fault,) = problem(answer, 422, "invalid-input")["errors"]
    assert fault["parameter"] == "max_degree"


@pytest.mark.parametrize("body", [b"", b"{", b"\xff", b"[" * 5000, b"[]x"])
def test_a_body_that_is_no_json(client: httpx.Client, body: bytes) -> None:
    problem(post(client, body), 400, "malformed-input")


@pytest.mark.parametrize("body", [b"", b"\x93NUMPY", npy(ellipse())[:-3], npy(np.array([None]))])
def test_a_body_that_is_no_npy(client: httpx.Client, body: bytes) -> None:
    problem(client.post("/v1/fits", content=body, headers=NPY), 400, "malformed-input")


@pytest.mark.parametrize("kind", ["text/plain", "application/xml", "", "nonsense", "é".encode("latin-1")])
def test_a_media_type_that_is_not_read(client: httpx.Client, kind: str | bytes) -> None:
    answer = client.post(
        "/v1/fits", content=b"{}", headers={b"Content-Type": kind if isinstance(kind, bytes) else kind.encode()}
    )
    problem(answer, 415, "unsupported-media-type")


def test_an_encoding_that_is_not_read(client: httpx.Client) -> None:
    answer = client.post("/v1/fits", content=b"{}", headers=JSON | {"Content-Encoding": "gzip"})
    problem(answer, 415, "unsupported-media-type")


def test_a_message_that_quotes_the_caller_is_one_line_without_control_characters(client: httpx.Client) -> None:
    told = problem(client.get("/v1/fits/a%0D%0Ab%1B[2J%7F"), 404, "fit-not-found")
    assert told["detail"] == "there is no fit a  b [2J "


@pytest.mark.parametrize(
    "path",
    [
        "/nowhere",
        "/v1",
        "/v1/fits/x/y",
        "/docs/assets/none.js",
        "/livez/",
        "/v1/fits/",
        "/docs/assets/..%2f..%2fapp.py",
    ],
)
def test_an_unknown_path(client: httpx.Client, path: str) -> None:
    problem(client.get(path), 404, "not-found")


@pytest.mark.parametrize("path", ["/v1/fits/none", "/v1/fits/none/mesh", f"/v1/fits/{'x' * 5000}", "/v1/fits/%00%ff"])
def test_an_unknown_fit(client: httpx.Client, path: str) -> None:
    problem(client.get(path), 404, "fit-not-found")
    if not path.endswith("mesh"):
        problem(client.delete(path), 404, "fit-not-found")


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("PUT", "/v1/fits/none", "DELETE, GET, HEAD, OPTIONS"),
        ("POST", "/v1/fits/none/mesh", "GET, HEAD, OPTIONS"),
        ("POST", "/livez", "GET, HEAD, OPTIONS"),
        ("DELETE", "/docs", "GET, HEAD, OPTIONS"),
        ("PATCH", "/openapi.json", "GET, HEAD, OPTIONS"),
        ("POST", "/docs/assets/swagger-ui.css", "GET, HEAD, OPTIONS"),
        ("TRACE", "/v1/fits", "GET, HEAD, OPTIONS, POST"),
        ("PROPFIND", "/v1/fits", "GET, HEAD, OPTIONS, POST"),
        ("QUERY", "/livez", "GET, HEAD, OPTIONS"),
    ],
)
def test_a_wrong_method_is_told_the_right_ones(client: httpx.Client, method: str, path: str, allowed: str) -> None:
    answer = client.request(method, path)
    problem(answer, 405, "method-not-allowed")
    assert answer.headers["Allow"] == allowed


def test_a_method_that_is_none_of_http_is_not_implemented(client: httpx.Client) -> None:
    problem(client.request("BREW", "/v1/fits"), 501, "not-implemented")


@pytest.fixture(scope="module")
def mesh(client: httpx.Client) -> Iterator[str]:
    fit = client.post("/v1/fits", content=npy(sphere()), headers=NPY).json()
    yield f"/v1/fits/{fit['id']}/mesh"
    client.delete(f"/v1/fits/{fit['id']}?purge=true")


@pytest.mark.parametrize(
    "query",
    [
        "bounds=",
        "bounds=1,2,3",
        "bounds=a,b,c,d,e,f",
        "bounds=0,0,0,1,1,nan",
        "bounds=0,0,0,1,1,inf",
        "bounds=0,0,0,1,1,1e999",
        "bounds=1,1,1,0,0,0",
        "bounds=0,0,0,0,1,1",
        "bounds=0,0,0,1,1,1,1",
        "bounds=" + "1," * 5000,
        "bounds=-1e300,-1e300,-1e300,1e300,1e300,1e300",
        "resolution=100000",
        "resolution=257",
        "resolution=1",
        "resolution=-5",
        "resolution=1.5",
        "resolution=" + "9" * 5000,
        "extent=all",
        "format=docx",
    ],
)
def test_a_mesh_that_cannot_be_made(client: httpx.Client, mesh: str, query: str) -> None:
    answer = client.get(f"{mesh}?{query}")
    assert answer.status_code == 422, answer.text
    (fault,) = problem(answer, 422, answer.json()["code"])["errors"]
    assert fault["parameter"] == query.partition("=")[0]


def test_the_trace_id_is_the_callers_if_there_is_one(client: httpx.Client) -> None:
    trace = "4bf92f3577b34da6a3ce929d0e0e4736"
    sent = {"traceparent": f"00-{trace}-00f067aa0ba902b7-01"}
    assert client.get("/nowhere", headers=sent).json()["trace_id"] == trace
    for wrong in ("", "00-short-00f067aa0ba902b7-01", "x" * 5000):
        assert client.get("/nowhere", headers={"traceparent": wrong}).json()["trace_id"] not in (trace, wrong)


def test_a_very_long_query_is_no_trouble(client: httpx.Client) -> None:
    assert client.post(f"/v1/fits?{'x' * 50_000}=1", content=b"{}", headers=JSON).status_code in (414, 422)


def test_a_caller_who_leaves_in_the_middle_does_no_harm(client: httpx.Client) -> None:
    address = (client.base_url.host, client.base_url.port or 80)
    for _ in range(3):
        with socket.create_connection(address) as connection:
            connection.sendall(b"POST /v1/fits HTTP/1.1\r\nHost: x\r\nContent-Length: 900000\r\n\r\n{" + b" " * 300_000)
    assert client.get("/readyz").json() == {"status": "ok"}
