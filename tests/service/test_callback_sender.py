"""Sending a callback: what a receiver gets, where the connection goes, and what a bad receiver can do."""

import asyncio
import socket
import threading
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from service.callbacks import resolving
from service.callbacks import sender as module
from service.callbacks.addresses import AllowedAddresses
from service.callbacks.resolving import resolved
from service.callbacks.sender import HttpSender
from service.callbacks.signature import Signer
from service.jobs.delivery import Answer, NotDeliveredError
from tests.service.certificates import Authority
from tests.service.receivers import OTHER_SECRET, SECRET, receiver

BODY = b'{"type":"fit.ended"}'
Resolve = Callable[[str, int], Awaitable[list[str]]]


def names(*answers: list[str]) -> tuple[Resolve, list[str]]:
    """Return a name server that gives these answers one after the other, and the names that it was asked for."""
    asked: list[str] = []

    async def resolve(host: str, _port: int) -> list[str]:
        asked.append(host)
        return answers[min(len(asked), len(answers)) - 1]

    return resolve, asked


def sender(allowed: str = "127.0.0.0/8", resolve: Resolve = resolved, secrets: str = SECRET) -> HttpSender:
    return HttpSender(Signer.of(secrets), AllowedAddresses.of(allowed), allow_http=True, resolve=resolve)


def send(by: HttpSender, url: str) -> Answer:
    return asyncio.run(by.send(url, "ended-1", BODY))


def failure(by: HttpSender, url: str) -> str:
    with pytest.raises(NotDeliveredError) as failed:
        send(by, url)
    return str(failed.value)


def test_the_signature_is_that_of_the_specification() -> None:
    signer = Signer.of("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw")
    assert signer.headers("msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330, b'{"test": 2432232314}') == {
        "webhook-id": "msg_p5jXN8AQM9LWM0D4loKWxJek",
        "webhook-timestamp": "1614265330",
        "webhook-signature": "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=",
    }


def test_what_a_receiver_gets() -> None:
    with receiver() as to:
        assert send(sender(), f"{to.url}/hook?a=b%20c") == Answer(204)
        (message,) = to.messages
    assert (message.path, message.id, message.body) == ("/hook?a=b%20c", "ended-1", BODY)
    assert message.signed_with(SECRET)
    assert not message.signed_with(OTHER_SECRET)
    assert message.headers["content-type"] == "application/json"
    assert message.headers["host"] == f"127.0.0.1:{to.port}"


def test_with_several_secrets_there_is_a_signature_by_each() -> None:
    with receiver() as to:
        send(sender(secrets=f"{SECRET} {OTHER_SECRET}"), to.url)
        assert to.messages[0].signed_with(SECRET)
        assert to.messages[0].signed_with(OTHER_SECRET)


def test_the_connection_goes_to_the_address_that_was_checked() -> None:
    """A name server that gives another address to the second look-up gains nothing: there is none."""
    resolve, asked = names(["127.0.0.1"], ["127.0.0.2"])
    with receiver() as to:
        assert send(sender(resolve=resolve), f"http://hooks.example:{to.port}/") == Answer(204)
        assert to.messages[0].headers["host"] == f"hooks.example:{to.port}"
    assert asked == ["hooks.example"]


@pytest.mark.parametrize("found", [["127.0.0.1"], ["1.1.1.1", "127.0.0.1"], ["127.0.0.1", "1.1.1.1"], ["::1"], []])
def test_nothing_is_sent_if_any_address_is_not_public(found: list[str]) -> None:
    resolve, asked = names(found)
    with receiver() as to:
        told = failure(sender("", resolve), f"http://hooks.example:{to.port}/")
        assert to.messages == []
    assert asked == ["hooks.example"]
    assert told == "the host has no address, or not only public ones"


def test_a_name_that_becomes_private_later_is_refused_then() -> None:
    resolve, _ = names(["127.0.0.1"], ["127.0.0.1", "10.0.0.1"])
    with receiver() as to:
        by = sender(resolve=resolve)
        assert send(by, f"http://hooks.example:{to.port}/") == Answer(204)
        failure(by, f"http://hooks.example:{to.port}/")
        assert len(to.messages) == 1


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "[::ffff:127.0.0.1]", "[::1]"])
def test_this_machine_is_not_public(host: str) -> None:
    with receiver() as to:
        failure(sender(""), f"http://{host}:{to.port}/")
        assert to.messages == []


def test_a_name_that_does_not_exist_is_told_like_a_private_one() -> None:
    async def nobody(_host: str, _port: int) -> list[str]:
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    assert failure(sender("", nobody), "http://none.example/") == failure(
        sender("", names(["10.0.0.1"])[0]), "http://private.example/"
    )


def test_names_are_looked_up() -> None:
    assert set(asyncio.run(resolved("localhost", 80))) <= {"127.0.0.1", "::1"}
    with pytest.raises(OSError, match="label"):
        asyncio.run(resolved("a" * 64 + ".example", 80))  # no label is that long


def test_the_next_address_is_tried_if_one_cannot_be_reached() -> None:
    resolve, _ = names(["127.0.0.9", "127.0.0.1"])  # receivers listen at the second only
    with receiver() as to:
        assert send(sender(resolve=resolve), f"http://hooks.example:{to.port}/") == Answer(204)


@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
def test_redirects_are_not_followed(status: int) -> None:
    with receiver() as other, receiver(status, headers={"Location": f"{other.url}/"}) as to:
        assert send(sender(), to.url) == Answer(status)
        assert other.messages == []


def test_proxies_of_the_environment_are_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    with receiver() as proxy, receiver() as to:
        for name in ("http_proxy", "HTTP_PROXY", "https_proxy", "all_proxy", "ALL_PROXY"):
            monkeypatch.setenv(name, proxy.url)
        send(sender(), to.url)
        assert (len(proxy.messages), len(to.messages)) == (0, 1)


@pytest.mark.parametrize(
    ("value", "seconds"), [("120", 120.0), ("soon", 0.0), ("-5", 0.0), ("Thu, 01 Jan 1970 00:00:00 GMT", 0.0)]
)
def test_when_a_receiver_wants_to_be_asked_again(value: str, seconds: float) -> None:
    with receiver(503, headers={"Retry-After": value}) as to:
        assert send(sender(), to.url) == Answer(503, seconds)


def test_a_date_when_a_receiver_wants_to_be_asked_again() -> None:
    with receiver(429, headers={"Retry-After": "Fri, 31 Dec 2100 23:59:59 GMT"}) as to:
        assert send(sender(), to.url).retry_after > 86400.0


def test_tls_is_checked_by_the_name_and_not_by_the_address(tmp_path: Path) -> None:
    authority, (resolve, _) = Authority(tmp_path), names(["127.0.0.1"])
    by = HttpSender(Signer.of(SECRET), AllowedAddresses.of("127.0.0.0/8"), tls=authority.trusted(), resolve=resolve)
    with receiver(tls=authority.server("hooks.example")) as to:
        assert send(by, f"https://hooks.example:{to.port}/") == Answer(204)
        for url in (f"https://other.example:{to.port}/", f"{to.url}/"):
            assert "certificate is not valid" in failure(by, url)
        assert len(to.messages) == 1
    with receiver() as to:
        assert "TLS" in failure(by, f"https://hooks.example:{to.port}/")
        assert to.messages == []


def test_a_certificate_of_an_unknown_authority_is_refused(tmp_path: Path) -> None:
    resolve, _ = names(["127.0.0.1"])
    with receiver(tls=Authority(tmp_path).server("hooks.example")) as to:
        assert "certificate is not valid" in failure(sender(resolve=resolve), f"https://hooks.example:{to.port}/")
        assert to.messages == []


def test_a_receiver_that_is_not_there() -> None:
    with receiver() as to:
        port = to.port
    assert failure(sender(), f"http://127.0.0.1:{port}/") == "no connection: Connection refused"


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        (b"", "closed the connection"),
        (b"HTTP/1.1 200 OK\r\nA: ", "closed the connection"),
        (b"SSH-2.0-OpenSSH_9.2\r\n\r\n", "did not answer in HTTP"),
        (b"\x00" * 1000, "did not answer in HTTP"),
        (b"HTTP/1.1 200 OK\r\n" + b"A: b\r\n" * 100_000, "longer than"),
        (b"HTTP/1.1 100 Continue\r\n\r\n" * 100_000, "longer than"),
    ],
)
def test_what_is_no_answer(answer: bytes, why: str) -> None:
    with receiver(answer) as to:
        assert why in failure(sender(), to.url)


def test_little_of_an_endless_answer_is_read() -> None:
    head = b"HTTP/1.1 200 OK\r\n\r\n"
    with receiver(head + bytes(50_000_000)) as to:
        began = time.monotonic()
        assert send(sender(), to.url) == Answer(200)
        assert time.monotonic() - began < 5.0


def test_interim_answers_are_none() -> None:
    with receiver(b"HTTP/1.1 103 Early Hints\r\n\r\nHTTP/1.1 202 Accepted\r\nContent-Length: 0\r\n\r\n") as to:
        assert send(sender(), to.url) == Answer(202)


def test_a_receiver_that_does_not_answer_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "TRY_SECONDS", 0.3)
    with receiver(held=True) as to:
        assert failure(sender(), to.url) == "the receiver did not answer in time"
        assert len(to.messages) == 1


def test_a_host_that_cannot_be_looked_up_now_is_not_said_to_have_no_address(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither when no thread can be started, which leaves the places free, nor when all places are taken."""
    monkeypatch.setattr(resolving, "_free", threading.Semaphore(1))

    class Refused(threading.Thread):
        def start(self) -> None:
            raise RuntimeError("can't start new thread")

    for _ in range(2):
        with monkeypatch.context() as patched:
            patched.setattr(resolving, "Thread", Refused)
            told = failure(sender(), "http://hooks.example/")
        assert told == "no thread could be started to look up the host"
    monkeypatch.setattr(resolving, "_free", threading.Semaphore(0))
    assert failure(sender(), "http://hooks.example/") == "too many other hosts were being looked up"


def test_a_name_server_that_does_not_answer_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing waits for it then: neither the try, nor the end of the process."""
    silence = threading.Event()

    def unanswered(*_: object, **__: object) -> list[Any]:
        silence.wait(30.0)
        return []

    monkeypatch.setattr(module, "TRY_SECONDS", 0.3)
    monkeypatch.setattr(socket, "getaddrinfo", unanswered)
    began = time.monotonic()
    assert failure(sender(), "http://hooks.example/") == "the receiver did not answer in time"
    assert time.monotonic() - began < 15.0
    silence.set()
