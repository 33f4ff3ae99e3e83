"""What a peer may send, and how slowly: raw connections to a server with short time-outs."""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest

from service.connections.limits import ConnectionLimits
from service.connections.pace import Pace
from tests.service.raw import connected, talk
from tests.service.running import Server

HEAD_SECONDS, STALL_SECONDS, CONNECTIONS = 2.0, 2.0, 40
GET, POST = b"GET /livez HTTP/1.1\r\n", b"POST /v1/fits HTTP/1.1\r\n"
HOST, END, CLOSE = b"Host: x\r\n", b"\r\n", b"Connection: close\r\n"


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    folder = tmp_path_factory.mktemp("guarded") / "data"
    limits = {"HEAD_TIMEOUT": HEAD_SECONDS, "STALL_TIMEOUT": STALL_SECONDS, "MAX_CONNECTIONS": CONNECTIONS}
    server = Server(folder, FORWARDED_ALLOW_IPS="10.0.0.1", **limits)  # by default this machine is trusted
    yield server
    server.stop()


# By the status that they get.
REFUSED: dict[int, list[bytes]] = {
    400: [
        GET + END,
        GET + HOST + HOST + END,
        GET + HOST + b"Host: y\r\n" + END,
        b"garbage\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"GET /livez HTTP/9.9\r\n" + HOST + END,
        GET + HOST + b"No colon here\r\n" + END,
        GET + HOST + b"A\x00b: c\r\n" + END,
        POST + HOST + b"Content-Length: -1\r\n" + END,
        POST + HOST + b"Content-Length: 1\r\nContent-Length: 2\r\n" + END,
        POST + HOST + b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n" + END + b"0\r\n\r\n",
        POST + HOST + b"Transfer-Encoding: chunked\r\n" + END + b"zz\r\n",
    ],
    431: [
        GET + HOST + b"X: " + b"a" * 70_000 + END + END,
        GET + HOST + b"a: b\r\n" * 300 + END,
        b"GET /" + b"a" * 70_000 + b" HTTP/1.1\r\n" + HOST + END,
        b"GET /?" + b"a=1&" * 20_000 + b" HTTP/1.1\r\n" + HOST + END,
        GET + HOST + b"".join(b"a%d: %s\r\n" % (i, b"b" * 700) for i in range(100)) + END,
    ],
    501: [b"BREW /livez HTTP/1.1\r\n" + HOST + END, b"UPDATE /livez HTTP/1.1\r\n" + HOST + END,
          b"CONNECT x:443 HTTP/1.1\r\n" + HOST + END,
          b"get /livez HTTP/1.1\r\n" + HOST + END],
}  # fmt: skip


@pytest.mark.parametrize(("status", "sent"), [(status, one) for status, each in REFUSED.items() for one in each])
def test_what_is_no_request_is_refused_with_problem_details(guarded: Server, status: int, sent: bytes) -> None:
    answer = talk(guarded, sent)
    assert answer.status == status, answer
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.problem["status"] == status
    assert answer.seconds < HEAD_SECONDS + 1.0


def test_a_head_that_goes_on_for_ever_is_cut_off(guarded: Server) -> None:
    answer = talk(guarded, GET + HOST + b"X: ", *[b"a" * 10_000] * 50)
    assert answer.status in {431, 0}  # the answer is lost if the peer still sends
    assert httpx.get(f"{guarded.url}/livez").status_code == 200


def test_a_long_head_that_cannot_be_parsed_either_is_answered_once(guarded: Server) -> None:
    answer = talk(guarded, GET + HOST + b"X: ", b"a" * 40_000, b"a" * 30_000 + b"\x00\r\n", pause=0.2)
    assert answer.status in (400, 431)
    assert "Fatal error" not in guarded.log


def test_trailers_are_no_headers(guarded: Server) -> None:
    chunked = POST + HOST + CLOSE + b"Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n"
    plain, trailed = talk(guarded, chunked + END), talk(guarded, chunked + b"Content-Encoding: br\r\nHost: y\r\n\r\n")
    assert plain.status == trailed.status == 422
    assert plain.problem["detail"] == trailed.problem["detail"]


def test_chunks_that_hold_nothing_are_cut_off(guarded: Server) -> None:
    answer = talk(guarded, POST + HOST + b"Transfer-Encoding: chunked\r\n\r\n1;", *[b"a" * 30_000] * 10)
    assert answer.status in {400, 0}


@pytest.mark.parametrize("sent", [b"", b"G", GET, GET + HOST, GET + HOST + b"X: y"])
def test_a_head_that_does_not_arrive_is_not_waited_for(guarded: Server, sent: bytes) -> None:
    answer = talk(guarded, sent)
    assert answer.status == (408 if sent else 0)
    assert HEAD_SECONDS - 0.1 <= answer.seconds < HEAD_SECONDS + 3.0


def test_a_head_in_small_pieces_has_no_more_time(guarded: Server) -> None:
    answer = talk(guarded, *[bytes([one]) for one in GET + HOST], pause=0.2)
    assert answer.status == 408
    assert answer.seconds < len(GET + HOST) * 0.2


@pytest.mark.parametrize("pieces", [[b"{"], [b"{", *[b" "] * 20]])
def test_a_body_that_arrives_too_slowly_is_not_waited_for(guarded: Server, pieces: list[bytes]) -> None:
    answer = talk(guarded, POST + HOST + b"Content-Length: 100000\r\n\r\n", *pieces, pause=0.4)
    assert answer.status in {408, 0}
    assert answer.seconds < 20.0


def test_a_slow_but_steady_body_is_taken(guarded: Server) -> None:
    body = b'{"points": [[1, 0], [0, 1], [-1, 0], [0, -1]]' + b" " * 20_000 + b"}"
    pieces = [body[at : at + 4000] for at in range(0, len(body), 4000)]
    answer = talk(guarded, POST + HOST + CLOSE + b"Content-Length: %d\r\n\r\n" % len(body), *pieces, pause=0.7)
    assert answer.status == 200, answer


def test_a_peer_that_does_not_read_is_left(guarded: Server) -> None:
    connection = connected(guarded)
    connection.sendall((b"GET /openapi.json HTTP/1.1\r\n" + HOST + END) * 200)  # answers of some 10 MB
    time.sleep(STALL_SECONDS + 4.0)
    assert "a response that is not read" in guarded.log
    connection.close()


def test_requests_in_a_row_on_one_connection_are_answered(guarded: Server) -> None:
    answer = talk(guarded, (GET + HOST + END) * 5 + GET + HOST + CLOSE + END)
    assert answer.status == 200
    assert answer.body.count(b"HTTP/1.1 200 OK") == 5


def test_too_many_connections_of_one_address_are_refused_and_others_go_on(guarded: Server) -> None:
    held = [connected(guarded) for _ in range(CONNECTIONS // 2)]
    try:
        answers = [talk(guarded, GET + HOST + CLOSE + END) for _ in range(3)]
        assert any(answer.status == 503 for answer in answers)
        refused = next(answer for answer in answers if answer.status == 503)
        assert refused.problem["type"] == "/problems/too-many-connections"
        assert refused.headers["retry-after"] == "10"
    finally:
        for one in held:
            one.close()
    time.sleep(0.3)
    assert talk(guarded, GET + HOST + CLOSE + END).status == 200
    assert "connections from one address are the most here" in guarded.log


def test_silent_peers_do_not_keep_others_waiting(guarded: Server) -> None:
    silent = [connected(guarded) for _ in range(CONNECTIONS // 2 - 4)]
    with ThreadPoolExecutor(2) as threads:
        times = list(threads.map(lambda _: httpx.get(f"{guarded.url}/livez").elapsed.total_seconds(), range(50)))
    assert sorted(times)[48] < 0.5
    for one in silent:
        one.close()


def test_a_reader_is_late_if_it_takes_nothing() -> None:
    pace = Pace(ConnectionLimits(stall_seconds=10.0))
    assert not pace.reader_is_late(0.0, 100_000)
    assert not pace.reader_is_late(9.0, 100_000)
    assert not pace.reader_is_late(10.5, 50_000)  # it took half
    assert not pace.reader_is_late(20.0, 50_000)
    assert pace.reader_is_late(21.0, 49_000)
    assert not pace.reader_is_late(22.0, 0)


def test_reverse_proxies_have_no_limit_of_their_own() -> None:
    limits = ConnectionLimits.for_process(
        head_seconds=1.0, stall_seconds=1.0, connections=100, trusted=frozenset({"10.0.0.1"})
    )
    assert limits.connections_of_address == 50
    assert limits.is_trusted("10.0.0.1")
    assert not limits.is_trusted("10.0.0.2")
    assert ConnectionLimits(trusted=frozenset("*")).is_trusted("10.0.0.2")
