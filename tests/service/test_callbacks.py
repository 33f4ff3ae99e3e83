"""Callbacks over HTTP: asked for, refused, delivered by one server or by many, also after a crash."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import httpx
import jsonschema_rs
import pytest

from service.bootstrap.application import application
from service.settings import Settings
from tests.pages import DOCS, blocks
from tests.service.bodies import HALF_A_MINUTE, LONG, ellipse, npy
from tests.service.certificates import Authority
from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.receivers import ALLOWED, OTHER_SECRET, SECRET, Message, Receiver, receiver
from tests.service.running import Program, Server, until

NPY = {"Content-Type": "application/x-npy"}
DOCUMENT: dict[str, Any] = application(Settings()).openapi()
Start = Callable[..., Server]


@pytest.fixture(scope="module")
def sending(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = Server(tmp_path_factory.mktemp("sending") / "data", **ALLOWED)
    yield server
    server.stop()


def to(receiver: Receiver, path: str = "") -> str:
    return f"callback={quote(receiver.url + path, safe='')}"


def post(client: httpx.Client, query: str, **headers: str) -> httpx.Response:
    return client.post(f"/v1/fits?{query}", content=npy(ellipse()), headers=NPY | headers)


def state(server: Server, fit: dict[str, Any]) -> object:
    return server.look(fit)["callback"]["state"]


def delivered(server: Server, fit: dict[str, Any], seconds: float = 30.0) -> dict[str, Any]:
    """Return the fit when its callback has been delivered."""
    until(lambda: state(server, fit) == "delivered", seconds)
    return server.look(fit)


def is_genuine(message: Message, secret: str) -> bool:
    """Ask the function that docs/http.md shows."""
    (example,) = [text for _, text in blocks(DOCS / "http.md", "python") if "def is_genuine" in text]
    names: dict[str, Any] = {}
    exec(example, names)  # noqa: S102 - our own page
    return bool(names["is_genuine"](message.headers, message.body, secret))


def test_a_caller_is_told_of_the_end_as_the_documents_say(sending: Server) -> None:
    with receiver() as hook:
        fit = sending.fit(npy(ellipse()), to(hook, "/fits?for=me"))
        now = delivered(sending, fit)
        (message,) = hook.messages
    assert now["callback"] == {"url": f"{hook.url}/fits", "state": "delivered", "tries": 1, "last_error": None}
    assert "callback" not in now["options"]
    assert message.path == "/fits?for=me"
    assert message.event["data"] == {"id": fit["id"], "status": "successful", "path": f"/v1/fits/{fit['id']}"}
    assert message.event["timestamp"] == now["finished"]
    assert sending.client.get(message.event["data"]["path"]).json()["status"] == "successful"
    assert message.signed_with(SECRET)
    assert is_genuine(message, SECRET)
    assert not is_genuine(message, OTHER_SECRET)
    for name, what in (("FitEnded", message.event), ("FitResource", now)):
        jsonschema_rs.Draft202012Validator({"$ref": f"#/components/schemas/{name}", **DOCUMENT}).validate(what)
    operation = DOCUMENT["paths"]["/v1/fits"]["post"]["callbacks"]["fitEnded"]["{$request.query.callback}"]["post"]
    assert {one["name"] for one in operation["parameters"]} <= message.headers.keys()


def test_a_try_that_fails_is_seen_and_made_again(sending: Server) -> None:
    with receiver(500, 200) as hook:
        fit = sending.fit(npy(ellipse()), to(hook))
        until(lambda: sending.look(fit)["callback"]["last_error"])
        seen = sending.client.get(f"/v1/fits/{fit['id']}")
        assert seen.json()["callback"]["last_error"] == "the receiver answered 500"
        assert seen.json()["callback"]["state"] == "pending"
        assert delivered(sending, fit)["callback"]["tries"] == 2
        again = sending.client.get(f"/v1/fits/{fit['id']}", headers={"If-None-Match": seen.headers["ETag"]})
        assert again.status_code == 200
        assert len({message.id for message in hook.messages}) == 1


def test_a_fit_that_fails_is_told_of_too(start: Start) -> None:
    server = start(**ALLOWED, FIT_DEADLINE=0.5)
    with receiver() as hook:
        fit = server.fit(LONG, f"{HALF_A_MINUTE}&{to(hook)}")
        assert fit["status"] == "failed"
        delivered(server, fit)
        assert [message.event["data"]["status"] for message in hook.messages] == ["failed"]


def test_who_dismisses_a_fit_lets_it_be_known(sending: Server) -> None:
    with receiver() as hook:
        fit = sending.fit(LONG, f"{HALF_A_MINUTE}&{to(hook)}", "respond-async")
        assert fit["callback"] == {"url": hook.url, "state": "pending", "tries": 0, "last_error": None}
        assert hook.messages == []
        assert sending.client.delete(f"/v1/fits/{fit['id']}").json()["status"] == "dismissed"
        delivered(sending, fit)
        assert [message.event["data"]["status"] for message in hook.messages] == ["dismissed"]


def test_the_same_request_again_makes_no_second_message(sending: Server) -> None:
    with receiver() as hook:
        key = {"Idempotency-Key": '"told once"'}
        first, again = post(sending.client, to(hook), **key), post(sending.client, to(hook), **key)
        assert first.json()["id"] == again.json()["id"]
        delivered(sending, first.json())
        other = post(sending.client, to(hook, "/other"), **key)
        assert (other.status_code, other.json()["type"]) == (422, "/problems/key-reused")
        assert post(sending.client, "", **key).status_code == 422
        assert len(hook.messages) == 1


@pytest.mark.parametrize(
    "url", ["", "nonsense", "ftp://hooks.example/", "https://10.0.0.1/", "https://[::1]/", "https://a:b@hooks.example/"]
)
def test_what_cannot_be_sent_to_is_refused_with_its_parameter(sending: Server, url: str) -> None:
    answer = post(sending.client, f"callback={quote(url, safe='')}")
    assert (answer.status_code, answer.json()["type"]) == (422, "/problems/invalid-input")
    (fault,) = answer.json()["errors"]
    assert fault["parameter"] == "callback"


def test_a_server_without_a_secret_says_so(client: httpx.Client) -> None:
    answer = post(client, "callback=https%3A%2F%2Fhooks.example%2F")
    assert (answer.status_code, answer.json()["errors"][0]["parameter"]) == (422, "callback")
    assert "IPFIT_CALLBACK_SECRET" in answer.json()["detail"]


def test_by_default_only_https_is_sent(start: Start) -> None:
    server = start(CALLBACK_SECRET=SECRET, CALLBACK_ALLOW_PRIVATE="127.0.0.0/8")
    with receiver() as hook:
        assert "https://" in post(server.client, to(hook)).json()["detail"]


def test_https(start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    authority = Authority(tmp_path)
    monkeypatch.setenv("SSL_CERT_FILE", str(authority.file))
    server = start(CALLBACK_SECRET=f"{OTHER_SECRET} {SECRET}", CALLBACK_ALLOW_PRIVATE="127.0.0.0/8", ROOT_PATH="/tools")
    with receiver(tls=authority.server("127.0.0.1")) as hook:
        fit = server.fit(npy(ellipse()), to(hook))
        delivered(server, fit)
        (message,) = hook.messages
    assert message.signed_with(SECRET)
    assert message.signed_with(OTHER_SECRET)
    assert message.event["data"]["path"] == f"/tools/v1/fits/{fit['id']}"


def test_a_message_survives_the_server(start: Start) -> None:
    """It is stopped while the receiver is away, and killed while the receiver thinks about its answer."""
    first = start(**ALLOWED)
    with receiver(500, 200) as away, receiver(held=True) as slow:
        stopped, killed = (first.fit(npy(ellipse()), to(hook)) for hook in (away, slow))
        until(lambda: first.look(stopped)["callback"]["last_error"] and slow.messages)
        first.kill()
        second = start(**ALLOWED)
        delivered(second, stopped)
        assert state(second, killed) == "pending"
        second.stop()
        slow.go_on.set()
        third = start(**ALLOWED)
        assert delivered(third, killed, 60.0)["callback"]["tries"] > 1
        for hook in (away, slow):
            assert len({(message.id, message.body) for message in hook.messages}) == 1
    third.stop()
    for secret in (SECRET, SECRET.partition("_")[2]):
        assert all(secret not in log.read_text(encoding="utf-8") for log in third.folder.parent.glob("*.log"))


def test_a_cluster_delivers_each_message_once_and_again_if_its_server_dies(tmp_path: Path, postgres: Postgres) -> None:
    cluster = Cluster(tmp_path, postgres, **ALLOWED)
    try:
        servers, _ = [cluster.serve(), cluster.serve()], cluster.work()
        with receiver() as hook:
            fits = [servers[i % 2].fit(npy(ellipse()), to(hook), "respond-async") for i in range(6)]
            for i, fit in enumerate(fits):
                delivered(servers[1 - i % 2], fit, 60.0)
            assert sorted(message.event["data"]["id"] for message in hook.messages) == sorted(fit["id"] for fit in fits)
            assert all(message.signed_with(SECRET) for message in hook.messages)
        with receiver(held=True) as hook:
            fit = servers[0].fit(npy(ellipse()), to(hook))
            until(lambda: hook.messages)
            for server in servers:
                server.kill()
            hook.go_on.set()
            assert delivered(cluster.serve(), fit, 60.0)["callback"]["tries"] == 2
            assert len(hook.messages) == 2
            assert len({(message.id, message.body) for message in hook.messages}) == 1
    finally:
        cluster.end()


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("CALLBACK_SECRET", "hunter2hunter2hunter2hunter2hunter2"),
        ("CALLBACK_SECRET", "whsec_aHVudGVyMg=="),  # too short
        ("CALLBACK_SECRET", f"{SECRET} whsec_hunter2"),
        ("CALLBACK_ALLOW_PRIVATE", "10.0.0.1/8"),
        ("CALLBACK_ALLOW_PRIVATE", "everything"),
        ("CALLBACK_ALLOW_HTTP", "perhaps"),
    ],
)
def test_a_setting_that_is_wrong_is_named_and_no_secret_is_told(tmp_path: Path, setting: str, value: str) -> None:
    program = Program("serve", tmp_path / "data", **{setting: value})
    assert program.process.wait(60.0) == 2
    assert f"IPFIT_{setting}: " in program.log
    assert not re.search("hunter2|aHVudGVyMg", program.log)
    assert SECRET not in program.log
