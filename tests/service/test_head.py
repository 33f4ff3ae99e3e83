"""HEAD: as GET, without the body, on every route."""

import httpx
import pytest

from tests.service.bodies import npy, sphere
from tests.service.running import Server

PATHS = ["/livez", "/readyz", "/docs", "/", "/openapi.json", "/docs/assets/swagger-ui.css"]
CHANGING = {"date", "x-request-id", "traceparent", "server-timing"}


def same(client: httpx.Client, path: str) -> None:
    get, head = client.get(path, follow_redirects=False), client.head(path, follow_redirects=False)
    assert head.status_code == get.status_code
    assert head.content == b""
    assert {name: value for name, value in head.headers.items() if name not in CHANGING} == {
        name: value for name, value in get.headers.items() if name not in CHANGING
    }


@pytest.mark.parametrize("path", PATHS)
def test_head_is_get_without_the_body(client: httpx.Client, path: str) -> None:
    same(client, path)


def test_head_of_a_fit_and_of_its_mesh(shared: Server) -> None:
    fit = shared.fit(npy(sphere()))
    same(shared.client, f"/v1/fits/{fit['id']}")
    same(shared.client, f"/v1/fits/{fit['id']}/mesh?resolution=16&format=ply")
    same(shared.client, f"/v1/fits/{fit['id']}/mesh?format=svg")  # 406


@pytest.mark.parametrize("path", ["/v1/fits/nobody", "/nowhere", "/v1/fits?status=none"])
def test_head_of_what_get_is_refused_is_refused(client: httpx.Client, path: str) -> None:
    get, head = client.get(path), client.head(path)
    assert (head.status_code, head.content) == (get.status_code, b"")
    assert head.headers["content-type"] == "application/problem+json"


def test_after_a_head_the_connection_goes_on(client: httpx.Client) -> None:
    for _ in range(3):
        assert client.head("/openapi.json").status_code == 200
        assert client.get("/livez").json() == {"status": "ok"}


def test_allow_names_head_beside_get(client: httpx.Client) -> None:
    assert client.post("/livez").headers["allow"] == "GET, HEAD, OPTIONS"
    assert client.put("/v1/fits/x").headers["allow"] == "DELETE, GET, HEAD, OPTIONS"
