"""Connections: requests in a row, in pieces, cut off, and closed by halves."""

from tests.service.hostile.cases import BODY, CLOSE, CURVE, END, HOST, REFUSED, TAKEN, UNKNOWN, Case, get, post

LIVEZ = b"GET /livez HTTP/1.1\r\n" + HOST + END
LAST = b"GET /livez HTTP/1.1\r\n" + HOST + CLOSE + END
WAITING = b"GET /v1/fits/" + CURVE + b" HTTP/1.1\r\n" + HOST + b"Prefer: wait=1\r\n" + END
FITTED = b"POST /v1/fits HTTP/1.1\r\n" + HOST + b"Content-Length: %d\r\n\r\n" % len(BODY) + BODY
WHOLE = post()
POST = b"POST /v1/fits HTTP/1.1\r\n"
CHUNKED = HOST + b"Transfer-Encoding: chunked\r\n\r\n"
UPGRADE = b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Key: x\r\nSec-WebSocket-Version: 13\r\n\r\n"
# Requests in a row on one connection: what is sent, and how many answers may come.
ROWS = {
    "500 in one piece": (LIVEZ * 500 + LAST, 501), "500 with blank lines between": ((END + LIVEZ) * 500 + LAST, 501),
    "100 in chunks": ((b"GET /livez HTTP/1.1\r\n" + CHUNKED + b"0\r\n\r\n") * 100 + LAST, 101),
    "DELETE of no fit": ((b"DELETE /v1/fits/x HTTP/1.1\r\n" + HOST + END) * 20 + LAST, 21),
    "20 fits": (FITTED.replace(HOST, HOST + b"Prefer: respond-async\r\n") * 20 + LAST, 21),
    "errors in a row": ((b"GET /nothing HTTP/1.1\r\n" + HOST + END) * 100 + LAST, 101),
    "GET, then garbage": (LIVEZ + b"garbage\r\n\r\n", 2), "two fits, then garbage": (FITTED * 2 + b"\x00\x01\x02", 3),
    "waiting, then garbage": (WAITING + b"\xff" * 100, 2),
    "GET, then an unknown method": (LIVEZ + b"BREW / HTTP/1.1\r\n" + HOST + END, 2),
    "GET, then no Host": (LIVEZ + b"GET / HTTP/1.1\r\n\r\n", 2),
    "GET, then a long head": (LIVEZ + b"GET / HTTP/1.1\r\nX: " + b"a" * 70_000 + END + END, 2),
    "fits, then a broken body": (FITTED * 2 + POST + CHUNKED + b"zz\r\n", 3),
    "a broken body, then GET": (POST + CHUNKED + b"2\r\n{}zz" + LAST, 1),
    "refused early, then a broken body": (POST + b"Content-Type: a/b\r\n" + CHUNKED + b"1\r\nabc\r\n" + LAST, 1),
    "refused early, then GET": (FITTED.replace(HOST, HOST + b"Content-Type: a/b\r\n") + LAST, 2),
    "close, then more": (LAST + LIVEZ * 50, 1),
    "HTTP/1.0, then more": (b"GET /livez HTTP/1.0\r\n\r\n" + LIVEZ * 5, 1),
    "Expect, and the body at once": (FITTED.replace(HOST, HOST + b"Expect: 100-continue\r\n") + LAST, 2),
    "Upgrade, then frames": (b"GET /livez HTTP/1.1\r\n" + HOST + UPGRADE + b"\x81\x85" * 10, 1),
    "Upgrade to h2c": (b"GET /livez HTTP/1.1\r\n" + HOST + UPGRADE.replace(b"websocket", b"h2c"), 1),
    "CONNECT, then a tunnel": (b"CONNECT x:1 HTTP/1.1\r\n" + HOST + END + LIVEZ, 1),
}  # fmt: skip


def rows() -> list[Case]:
    """Return requests in a row, answered one after the other or refused."""
    return [Case(name, (sent,), UNKNOWN | TAKEN, answers=n, may_close=True) for name, (sent, n) in ROWS.items()]


def pieces() -> list[Case]:
    """Return requests that are cut in two at every strange place, and then go on."""
    where = [
        1,
        3,
        4,
        10,
        20,
        28,
        WHOLE.index(b"\r\n") + 1,
        WHOLE.index(b"\r\n\r\n") + 1,
        WHOLE.index(b"\r\n\r\n") + 3,
        len(WHOLE) - 1,
    ]
    found = [Case(f"cut at {at}", (WHOLE[:at], WHOLE[at:]), TAKEN) for at in where]
    letters = (*(bytes([one]) for one in LAST[:8]), LAST[8:])
    return [
        *found,
        Case("letter by letter", letters, TAKEN),
        Case("a row, cut", (LIVEZ * 3 + LAST[:9], LAST[9:]), TAKEN, answers=4),
    ]


def cut_off() -> list[Case]:
    """Return requests of which only a part comes, before the client says that no more does."""
    where = [0, 1, 4, 20, WHOLE.index(b"\r\n\r\n") + 2, WHOLE.index(b"\r\n\r\n") + 4, len(WHOLE) - 1]
    found = [
        Case(f"the first {at} bytes", (WHOLE[:at],), REFUSED | TAKEN, may_close=True, half_close=True) for at in where
    ]
    whole = {"a whole GET": get("/livez"), "a whole fit": WHOLE, "a row": LIVEZ * 50, "a GET that waits": WAITING}
    found += [Case(name, (sent,), TAKEN, answers=50, may_close=True, half_close=True) for name, sent in whole.items()]
    late = {
        "no head": b"",
        "half a head": LIVEZ[:-2],
        "half a body": FITTED[:-5],
        "a head after a GET": LIVEZ + LIVEZ[:-2],
    }
    return [
        *found,
        *(
            Case(f"nothing after {name}", (sent,), REFUSED | TAKEN, answers=2, may_close=True)
            for name, sent in late.items()
        ),
    ]
