"""Behind a proxy that removes a prefix: every link that the server gives begins with the prefix."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest

from service.settings import Settings
from tests.service.bodies import npy, sphere
from tests.service.proxies import PREFIX, PROGRAMS, installed_proxy, plain_proxy, program
from tests.service.running import Server


@pytest.fixture(params=["plain", *PROGRAMS])
def address(request: pytest.FixtureRequest, start: Callable[..., Server], tmp_path: Path) -> Iterator[str]:
    name = request.param
    if name in PROGRAMS and program(name) is None:
        pytest.skip(f"{name} is not installed here")
    server = start(ROOT_PATH=PREFIX)
    folder = tmp_path / name
    folder.mkdir(mode=0o777)
    with plain_proxy(server.url) if name == "plain" else installed_proxy(name, server.url, folder) as proxy:
        yield proxy


def test_every_link_leads_somewhere_through_the_proxy(address: str) -> None:
    origin = address.removesuffix(PREFIX)
    with httpx.Client(timeout=60.0) as client:
        sent = {"Content-Type": "application/x-npy", "Prefer": "respond-async"}
        accepted = client.post(f"{address}/v1/fits", content=npy(sphere()), headers=sent)
        assert accepted.status_code == 202, accepted.text
        for name in ("location", "content-location"):
            fit = client.get(origin + accepted.headers[name], headers={"Prefer": "wait=30"})
            assert fit.json()["status"] == "successful"
        mesh = client.get(f"{origin}{accepted.headers['location']}/mesh?format=ply")
        assert mesh.content.startswith(b"ply")
        moved = client.get(f"{address}/")
        assert moved.headers["location"] == f"{PREFIX}/docs"
        page = client.get(origin + moved.headers["location"])
        links = re.findall(r'(?:src|href)="([^"]+)"', page.text) + re.findall(r"url: '([^']+)'", page.text)
        assert len(links) >= 4
        for link in links:
            assert link.startswith(PREFIX), link
            assert client.get(origin + link).status_code == 200, link
        document = client.get(f"{address}/openapi.json").json()
        assert [server["url"] for server in document["servers"]] == [PREFIX]
        assert client.get(f"{address}/v1/fits/nobody").status_code == 404


def test_without_a_prefix_links_are_as_they_were(client: httpx.Client) -> None:
    assert client.get("/", follow_redirects=False).headers["location"] == "/docs"
    assert [server["url"] for server in client.get("/openapi.json").json()["servers"]] == ["/"]


@pytest.mark.parametrize("wrong", ["ipfit", "/ipfit/", "/", "/a b", "//x", "/ä"])
def test_a_root_path_that_is_none_is_refused_by_name(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IPFIT_ROOT_PATH", wrong)
    with pytest.raises(ValueError, match="root_path"):
        Settings()
