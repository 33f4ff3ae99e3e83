"""The Prefer header (RFC 7240)."""

import pytest
from starlette.requests import Request

from service.api.preferences import Preferences


def sent(*lines: str) -> Preferences:
    return Preferences.of(Request({"type": "http", "headers": [(b"prefer", line.encode("latin-1")) for line in lines]}))


@pytest.mark.parametrize(
    ("lines", "wait", "respond_async"),
    [
        ((), None, False),
        (("wait=10",), 10.0, False),
        (('WAIT = "10"',), 10.0, False),
        (("respond-async",), None, True),
        (("respond-async, wait=10",), 10.0, True),
        (("respond-async; foo=bar", "wait=5"), 5.0, True),
        (("wait=5, wait=7",), 5.0, False),
        (("wait=-1",), None, False),
        (("wait=1.5",), None, False),
        (("wait=soon",), None, False),
        (("wait=99999999999999999999",), None, False),
        (("wait=\xb2",), None, False),
        (("return=minimal, handling=lenient",), None, False),
        (("respond-asynchronously",), None, False),
        (
            (
                "",
                ",;,=",
            ),
            None,
            False,
        ),
    ],
)
def test_what_is_understood(lines: tuple[str, ...], wait: float | None, respond_async: bool) -> None:
    assert sent(*lines) == Preferences(wait, respond_async)


@pytest.mark.parametrize(
    ("line", "seconds", "applied"),
    [
        ("", 30.0, None),
        ("respond-async", 0.0, "respond-async"),
        ("wait=10", 10.0, "wait=10"),
        ("wait=0", 0.0, "wait=0"),
        ("wait=1000", 60.0, "wait=60"),
        ("respond-async, wait=2", 2.0, "respond-async, wait=2"),
    ],
)
def test_how_long_to_wait_and_what_is_said_about_it(line: str, seconds: float, applied: str | None) -> None:
    preferences = sent(line)
    assert preferences.seconds(30.0, 60.0) == seconds
    assert preferences.applied(seconds) == ({} if applied is None else {"Preference-Applied": applied})


def test_the_servers_limit_holds_for_the_default_too() -> None:
    assert Preferences().seconds(30.0, 5.0) == 5.0
