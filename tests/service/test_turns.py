"""The time of the event loop is shared: by address, in pieces, and with no more requests held than are answered."""

import asyncio
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Thread

import pytest

from service.connections.turns import Turns
from tests.service.bodies import ellipse, npy
from tests.service.raw import connected, talk
from tests.service.running import Server, until

LIVEZ = b"GET /livez HTTP/1.1\r\nHost: x\r\n\r\n"
FIT = npy(ellipse())
POST = b"POST /v1/fits?format=npy HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % len(FIT) + FIT
CHUNKED = b"POST /v1/fits HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n"
LAST = b"GET /livez HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"


@pytest.fixture(scope="module")
def shares(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = Server(tmp_path_factory.mktemp("shares") / "data", HEAD_TIMEOUT=1, STALL_TIMEOUT=2)
    yield server
    server.stop()


def in_order(*wanted: tuple[str, int]) -> str:
    """Return the addresses in the order of their pieces, when each wants so many turns at once."""
    done: list[str] = []

    async def main() -> None:
        turns = Turns()
        for address, count in wanted:
            for _ in range(count):
                turns.take(address, lambda address=address: done.append(address))  # type: ignore[misc] # mypy and defaults
        for _ in range(20):
            await asyncio.sleep(0)

    asyncio.run(main())
    return "".join(done)


def test_the_first_piece_of_an_address_is_done_at_once_and_the_others_in_turn() -> None:
    assert in_order(("a", 1), ("b", 1)) == "ab"
    assert in_order(("a", 4), ("b", 2)) == "abab" + "aa"


def test_turns_that_are_taken_in_a_turn_wait_for_the_next_round() -> None:
    seen: list[int] = []

    async def main() -> None:
        turns = Turns()

        def again() -> None:
            seen.append(len(rounds))
            if len(seen) < 5:
                turns.take("a", again)

        rounds: list[None] = []
        turns.take("a", again)
        while len(seen) < 5:
            rounds.append(None)
            await asyncio.sleep(0)

    asyncio.run(main())
    assert seen == sorted(set(seen))


def memory(server: Server) -> int:
    """Return the most memory that the server had so far, in MB."""
    status = (Path("/proc") / str(server.process.pid) / "status").read_text(encoding="utf-8")
    return int(status.partition("VmHWM:")[2].split()[0]) // 1024


@pytest.mark.parametrize(("first", "then"), [(b"", LIVEZ), (CHUNKED, b"1\r\n \r\n")], ids=["requests", "chunks"])
def test_a_flood_is_not_held_in_memory(start: Callable[..., Server], first: bytes, then: bytes) -> None:
    server = start(STALL_TIMEOUT=2)
    before, sent = memory(server), [0] * 4

    def flood(i: int) -> None:
        with connected(server) as connection:
            connection.settimeout(1.0)
            connection.sendall(first)
            end = time.monotonic() + 3.0
            try:
                while time.monotonic() < end:
                    sent[i] += connection.send(then * 50_000)
            except OSError:
                pass  # the server reads no more, or has cut the connection

    floods = [Thread(target=flood, args=(i,)) for i in range(len(sent))]
    for one in floods:
        one.start()
    for one in floods:
        one.join()
    assert server.client.get("/livez").is_success
    assert memory(server) - before < 50
    assert min(sent) > 100_000
    server.stop()


def test_others_are_answered_during_a_flood(shares: Server) -> None:
    flood = Thread(target=talk, args=(shares, LIVEZ * 3000 + LAST))
    flood.start()
    answered = 0
    while flood.is_alive() and answered < 10:
        assert talk(shares, LAST).status == 200
        answered += 1
    assert answered == 10  # before the flood was through
    shares.client.get("/livez")
    flood.join()


def test_a_request_behind_others_that_cannot_be_read_is_refused_after_their_answers(shares: Server) -> None:
    for before in (LIVEZ * 3, POST * 2):
        for broken in (b"\x00", b"GET / HTTP/1.1\r\n\r\n", LIVEZ[:-2] + b"Transfer-Encoding: chunked\r\n\r\nzz\r\n"):
            answer = talk(shares, before + broken)
            statuses = [answer.status, *(int(part[:3]) for part in answer.body.split(b"HTTP/1.1 ")[1:])]
            assert statuses == [200] * before.count(b" HTTP/1.1\r\n") + [400], (before, broken, answer)


def test_a_body_that_breaks_off_after_an_early_answer_is_no_error(shares: Server) -> None:
    early = b"POST /v1/fits HTTP/1.1\r\nHost: x\r\nContent-Type: a/b\r\nTransfer-Encoding: chunked\r\n\r\n1\r\na"
    answers = {talk(shares, early + b"zz").status, talk(shares, early, b"zz", pause=0.2).status}
    assert answers <= {400, 415}
    assert "Traceback" not in shares.log


def test_a_part_of_a_head_behind_a_request_that_waits_does_not_end_it(shares: Server) -> None:
    long = shares.fit(npy(ellipse(2000)), "t1=0&max_degree=30", "respond-async")
    waiting = f"GET /v1/fits/{long['id']} HTTP/1.1\r\nHost: x\r\nPrefer: wait=3\r\n\r\n".encode()
    answer = talk(shares, waiting + LIVEZ[:-2])
    assert answer.status == 200
    shares.client.delete(f"/v1/fits/{long['id']}")


def test_fits_of_clients_that_left_before_their_turn_are_not_made(shares: Server) -> None:
    with connected(shares) as connection:
        connection.sendall(POST * 500)
    assert shares.client.get("/livez").is_success
    until(lambda: shares.fit(FIT)["status"] == "successful")
    assert shares.log.count('"POST /v1/fits?format=npy HTTP/1.1" 20') < 400
