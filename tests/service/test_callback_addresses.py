"""Where callbacks may go: every address and every URL of these tables."""

import re
import socket

import h11
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.callbacks.addresses import AllowedAddresses
from service.callbacks.sender import HttpSender
from service.callbacks.signature import Signer
from service.callbacks.target import Target
from service.jobs.errors import InvalidInputError

PUBLIC = ["1.1.1.1", "93.184.215.14", "172.15.255.255", "172.32.0.1", "100.128.0.1", "2606:4700::1111", "2a00:1450::1"]
NOT_PUBLIC = [
    "0.0.0.0",  # noqa: S104 - not bound
    "0.1.2.3",
    "10.0.0.1",
    "100.64.0.1",  # shared by providers
    "127.0.0.1",
    "127.255.255.254",
    "169.254.169.254",  # the metadata of a cloud
    "172.16.0.1",
    "172.31.255.255",
    "192.0.0.9",
    "192.0.2.1",
    "192.88.99.1",
    "192.168.1.1",
    "198.18.0.1",
    "198.51.100.1",
    "203.0.113.1",
    "224.0.0.1",
    "239.255.255.250",
    "240.0.0.1",
    "255.255.255.255",
    "::",
    "::1",
    "::7f00:1",  # IPv4-compatible
    "::ffff:127.0.0.1",
    "::ffff:10.0.0.1",
    "::ffff:1.1.1.1",
    "64:ff9b::a00:1",  # NAT64 of 10.0.0.1
    "64:ff9b::101:101",
    "64:ff9b:1::1",
    "100::1",
    "2001::1",  # Teredo
    "2001:db8::1",
    "2002:a00:1::1",  # 6to4 of 10.0.0.1
    "2002:101:101::1",
    "3fff::1",
    "5f00::1",
    "fc00::1",
    "fd12:3456::1",
    "fe80::1",
    "fe80::1%eth0",
    "fec0::1",
    "ff02::1",
    "ff0e::1",
]


def sender(allowed: str = "", *, allow_http: bool = False) -> HttpSender:
    return HttpSender(Signer((b"key",)), AllowedAddresses.of(allowed), allow_http=allow_http)


@pytest.mark.parametrize("address", PUBLIC)
def test_public_addresses_are_allowed(address: str) -> None:
    assert AllowedAddresses().has(address)


@pytest.mark.parametrize("address", NOT_PUBLIC)
def test_all_others_are_not(address: str) -> None:
    assert not AllowedAddresses().has(address)
    assert not AllowedAddresses.of("10.9.0.0/16, fd00:9::/32").has(address)


@pytest.mark.parametrize("address", NOT_PUBLIC)
def test_but_networks_that_are_named_are(address: str) -> None:
    assert AllowedAddresses.of(f"203.0.113.77/32,{address.partition('%')[0]}").has(address.partition("%")[0])


@pytest.mark.parametrize("address", [one for one in NOT_PUBLIC if "%" not in one])
def test_a_url_with_such_an_address_is_refused_when_it_comes(address: str) -> None:
    host = f"[{address}]" if ":" in address else address
    with pytest.raises(InvalidInputError, match="not public") as refused:
        sender().check(f"https://{host}:8443/hook")
    assert refused.value.at == ("callback",)
    sender(address).check(f"https://{host}:8443/hook")


@pytest.mark.parametrize(
    "url",
    [
        "https://hooks.example/fits",
        "https://hooks.example",
        "https://HOOKS.example:8443/a/b%20c?d=e&f=%2F;g",
        "HTTPS://a_b.hooks-2.example/",
        "https://1.1.1.1/",
        "https://[2606:4700::1111]/",
        "https://2.example/",
        "https://xn--bcher-kva.example/",
    ],
)
def test_urls_that_are_taken(url: str) -> None:
    sender().check(url)


@pytest.mark.parametrize(
    "url",
    [
        "",
        "hooks.example",
        "//hooks.example/",
        "/fits",
        "http://hooks.example/",
        "ftp://hooks.example/",
        "file:///etc/passwd",
        "gopher://hooks.example/",
        "javascript:alert(1)",
        "https:hooks.example",
        "https:///hooks.example",
        "https://",
        "https://:443/",
        "https://hooks.example:0/",
        "https://hooks.example:65536/",
        "https://hooks.example:x/",
        "https://user@hooks.example/",
        "https://user:password@hooks.example/",
        "https://hooks.example@127.0.0.1/",
        "https://hooks.example\\@127.0.0.1/",
        "https://hooks.example/#part",
        "https://hooks.example/ a",
        "https://hooks.example/\r\nHost: other",
        "https://hooks.example/\x00",
        "https://hooks.example/é",
        "https://bücher.example/",
        "https://hooks..example/",
        "https://hooks.example./",
        "https://-hooks.example/",
        "https://" + "a" * 64 + ".example/",
        "https://hooks.example/" + "a" * 2000,
        "https://2130706433/",  # 127.0.0.1 for many resolvers, as are the next ones
        "https://0x7f000001/",
        "https://0x7f.1/",
        "https://127.1/",
        "https://0177.0.0.1/",
        "https://127.0.0.1./",
        "https://[::1/",
        "https://[fe80::1%25eth0]/",
        "https://[hooks.example]/",
        "https://[v1.hooks]/",
        "https://[::1].hooks.example/",
        "https://[2606:4700::1111]hooks.example/",
    ],
)
def test_urls_that_are_refused(url: str) -> None:
    with pytest.raises(InvalidInputError, match="callback cannot be sent") as refused:
        sender().check(url)
    assert refused.value.at == ("callback",)
    assert len(str(refused.value)) < 200


@settings(max_examples=500, deadline=None)
@given(st.lists(st.sampled_from([*"abc019.:/?@[]%&=-_", "https://", "::1", "127.0.0.1", "hooks.example"]), max_size=12))
def test_what_is_taken_makes_one_request_to_the_host_that_was_looked_at(parts: list[str]) -> None:
    url = "https://" + "".join(parts)
    try:
        target = Target.of(url, allow_http=False)
    except ValueError:
        return
    assert url[8:].startswith(target.authority.partition(":")[0] if ":" not in target.host else f"[{target.host}]")
    assert re.fullmatch(r"[a-z0-9._-]+|[0-9a-f:.]+", target.host)
    h11.Request(method="POST", target=target.path, headers=[("Host", target.authority)])  # raises if it cannot be sent


def test_http_is_taken_if_that_is_allowed() -> None:
    sender(allow_http=True).check("http://hooks.example/")


def test_no_look_up_when_a_url_is_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    """A caller must not make the server wait for a resolver that does not answer."""
    asked: list[object] = []
    monkeypatch.setattr(socket, "getaddrinfo", lambda *given, **_: asked.append(given))
    sender().check("https://hooks.example/")
    assert asked == []
