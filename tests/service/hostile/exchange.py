"""Sending a hostile request, and reading what comes back as strictly as HTTP is written."""

import json
import re
import socket
import time
from contextlib import suppress
from dataclasses import dataclass, field

from tests.service.hostile.cases import Case
from tests.service.raw import connected
from tests.service.running import Server

SECONDS = 60.0  # that an answer may take, on a machine that is busy with other tests
SURPLUS_SECONDS = 0.03  # after the last answer that is due, to see one that is not
PAUSE = 0.05  # between pieces
STATUS_LINE = re.compile(rb"HTTP/1\.1 ([1-5]\d\d) [ -~]*")
FIELD = re.compile(rb"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([\t -~\x80-\xff]*)")


@dataclass(frozen=True)
class Answer:
    """One response."""

    status: int
    headers: dict[bytes, bytes]
    body: bytes


@dataclass
class Talk:
    """What came back on one connection."""

    answers: list[Answer] = field(default_factory=list)
    closed: bool = False
    seconds: float = 0.0
    rest: bytes = b""


def exchange(server: Server, case: Case) -> Talk:
    """Send a case, and read until the server closes or all answers are there that are due."""
    talk, began = Talk(), time.monotonic()
    with connected(server) as connection:
        with suppress(OSError):  # the server has closed: what it said is still to be read
            for piece in case.pieces:
                connection.sendall(piece)
                time.sleep(PAUSE if len(case.pieces) > 1 else 0.0)
            if case.half_close:
                connection.shutdown(socket.SHUT_WR)
        while not talk.closed and time.monotonic() - began < SECONDS:
            due = len(talk.answers) < case.answers or bool(talk.rest)
            connection.settimeout(SECONDS if due else SURPLUS_SECONDS)
            try:
                chunk = connection.recv(1 << 20)
            except TimeoutError:
                break
            except OSError:
                chunk = b""
            talk.closed = not chunk
            talk.rest += chunk
            _parse(talk, bodiless=case.bodiless)
    talk.seconds = time.monotonic() - began
    return talk


def _parse(talk: Talk, *, bodiless: bool) -> None:
    """Move every response that is complete from the rest to the answers."""
    while b"\r\n\r\n" in talk.rest:
        head, _, after = talk.rest.partition(b"\r\n\r\n")
        first, *lines = head.split(b"\r\n")
        found = STATUS_LINE.fullmatch(first)
        assert found is not None, first
        headers = _headers(lines)
        status = int(found.group(1))
        taken = _body(status, headers, after, bodiless=bodiless, closed=talk.closed)
        if taken is None:
            return
        body, talk.rest = taken
        if status >= 200:
            talk.answers.append(Answer(status, headers, body))


def _headers(lines: list[bytes]) -> dict[bytes, bytes]:
    headers: dict[bytes, bytes] = {}
    for line in lines:
        found = FIELD.fullmatch(line)
        assert found is not None, line
        name = found.group(1).lower()
        assert name not in {b"content-length", b"transfer-encoding", b"content-type"} & headers.keys(), lines
        headers[name] = found.group(2)
    return headers


def _body(
    status: int, headers: dict[bytes, bytes], after: bytes, *, bodiless: bool, closed: bool
) -> tuple[bytes, bytes] | None:
    """Return the body and what follows it, or None if it is not there yet."""
    if bodiless or status < 200 or status in {204, 304}:
        return b"", after
    if b"content-length" in headers:
        length = int(headers[b"content-length"])
        return None if len(after) < length else (after[:length], after[length:])
    if b"transfer-encoding" not in headers:
        return (after, b"") if closed else None
    assert headers[b"transfer-encoding"] == b"chunked"
    body = b""
    while b"\r\n" in after:
        size, _, after = after.partition(b"\r\n")
        length = int(size, 16)
        if len(after) < length + 2:
            return None
        body, after = body + after[:length], after[length + 2 :]
        if not length:
            return body, after
    return None


def check_problem(answer: Answer) -> None:
    """Assert that the body of an error is problem details (RFC 9457), as the OpenAPI document describes them."""
    assert answer.headers[b"content-type"] == b"application/problem+json", answer
    problem = json.loads(answer.body)
    texts = ("type", "code", "title", "detail", "trace_id", "request_id")
    kinds = dict.fromkeys(texts, str) | {"status": int, "errors": list}
    assert {name: type(value) for name, value in problem.items()} == kinds, problem
    assert problem["status"] == answer.status
    assert problem["type"] == f"/problems/{problem['code']}", problem
    assert len(answer.body) < 8000, "an error does not repeat what was sent"
