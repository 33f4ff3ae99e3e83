"""Headers: names and values that are none, and values that say what no server should believe."""

from tests.service.hostile.cases import CLOSE, CURVE, END, HOST, REFUSED, TAKEN, Case, get, post

# Lines as they stand, in a GET of /livez: they are no headers, or hold what a header may not.
LINES = [
    b"No colon", b": no name", b"Name : x", b"Na me: x", b"Name\t: x", b"\x00: x", b"A\x00B: x", b"A: \x00",
    b"A: b\x00c", b"A: \x01", b"A: \x7f", b"A: \x1b[31m", b"A: \x0b", b"A: \xff\xfe", b"A: \xc3\xa9",
    b"A: \xf0\x9f\x90\x8e", b"\xc3\xa9: x", b"A\xff: x", b"(A): x", b"A@: x", b"A/B: x", b"{A}: x", b"A: ", b"A:",
    b"A:b", b"A:" + b" " * 5000 + b"b", b"A: b" + b" " * 5000, b"a" * 5000 + b": b", b"A: " + b"b" * 60_000,
    b"A: " + b"b" * 70_000, b"A: b\r\n" * 200 + b"B: c", b"A: b\r\n" * 300 + b"B: c", b"A: b\rB: c", b"A: b\nB: c",
    b"Host:", b"Host: ", b"Host: x", b"host: y", b"Host: \xff", b"HOST\t: x", b"__proto__: x", b"constructor: x",
]  # fmt: skip
HOSTS = [
    b"", b"x y", b"x,y", b"x/y", b"x@y", b"[::1", b"\xff", b"x:99999", b"x:-1", b"a" * 50_000, b"<script>", b"x\\y",
    b"../..", b"'",
]  # fmt: skip

LONG = b"x" * 20_000
# Values by header, sent with a GET of a fit that exists.
VALUES: dict[bytes, list[bytes]] = {
    b"Range": [
        b"bytes=0-", b"bytes=-1", b"bytes=5-1", b"bytes=" + b"0-1," * 5000 + b"0-1", b"bytes=99999999999999999999-",
        b"x=y", b"bytes=a-b", b"bytes=0-0,-1", b"bytes=--1", b"bytes", b"\xff",
    ],
    b"Accept": [
        b"", b"*", b"*/*;q=2", b"*/*;q=-1", b"*/*;q=nan", b"*/*;q=inf", b"*/*;q=1e999", b"a/b;" * 5000,
        b"a/b," * 9000, b";;;", b",", b"model/*;q=0", b"*/*;q=0", b"\xff/\xff", b"application/json;q=0", b"text/html",
        b'*/*;a="b,c"', b"image/svg+xml;q=" + b"9" * 5000,
    ],
    b"Prefer": [
        b"wait=-1", b"wait=1e9", b"wait=0.5", b"wait=nan", b"wait=" + b"9" * 5000, b"wait=\xef\xbc\x91", b"wait",
        b"wait=", b'wait="', b"wait=0;" * 3000, b"wait=0, wait=5", b"respond-async, respond-async", b"return=minimal",
        b"=", b",;,;", b"\xff", b"wait=0x1", LONG,
    ],
    b"If-None-Match": [
        b"*", b'"', b'""', b"W/", b'W/"x"', b"x", b'"' + LONG + b'"', b'"x",' * 9000, b"\xff", b"*, *", b",",
    ],
    b"If-Match": [b"*", b'"x"', b"\xff"],
    b"If-Modified-Since": [b"x", b"Thu, 01 Jan 1970 00:00:00 GMT", b"Thu, 99 Jan 99999 99:99:99 GMT", b"\xff"],
    b"traceparent": [
        b"", b"00", b"00-" + b"0" * 32 + b"-" + b"0" * 16 + b"-00", b"ff-" + b"a" * 32 + b"-" + b"b" * 16 + b"-01",
        b"00-" + b"A" * 32, b"\xff", LONG, b"00-" + b"g" * 32 + b"-" + b"b" * 16 + b"-01",
        b"00-" + b"a" * 32 + b"-" + b"b" * 16 + b"-01\xff",
    ],
    b"X-Forwarded-For": [
        b"", b",", b"999.999.999.999", b"::1", b"1.2.3.4:99999", b"x" * 5000, b"1.2.3.4," * 5000, b"\xff", b"unknown",
        b"<script>", b"fe80::1%lo",
    ],
    b"X-Forwarded-Proto": [b"", b"gopher", b"https,http", b"\xff", b"x" * 5000, b"wss"],
    b"Connection": [b"keep-alive, close", b"Host", b"Transfer-Encoding", b"upgrade", b"x," * 9000, b"\xff", b""],
    b"Upgrade": [b"websocket", b"h2c", b"HTTP/2.0, SHTTP/1.3", b"\xff", b""],
    b"Expect": [b"100-continue", b"200-ok", b"", b"100-continue, x", b"\xff"],
    b"Origin": [b"null", b"http://evil", b"\xff"],
    b"Cookie": [b"a=b;" * 5000, b"\xff", b"="],
    b"Authorization": [b"Basic", b"Bearer", b"Basic !!!", b"Bearer " + LONG, b"\xff"],
    b"Accept-Encoding": [b"gzip;q=nan", b"*;q=0", b"gzip," * 5000, b"\xff"],
    b"TE": [b"trailers", b"gzip"],
    b"Max-Forwards": [b"-1", b"x"],
    b"X-HTTP-Method-Override": [b"DELETE"],
    b"Forwarded": [b"for=\xff", b'for="[x'],
    b"X-Original-URL": [b"/readyz"],
    b"Content-Length": [b"0", b"00000000000000000000"],
}  # fmt: skip
# Values by header, sent with a POST of a small point set.
POSTED: dict[bytes, list[bytes]] = {
    b"Content-Type": [
        b"", b"/", b"a", b"text/csv/x", b"application/json; charset=utf-16", b"application/json; charset=\xff",
        b"application/json;" * 3000, b"multipart/form-data", b"multipart/form-data; boundary=" + LONG,
        b"application/x-www-form-urlencoded", b"\xff", b"application/x-npy, text/csv", b"APPLICATION/JSON",
        b'application/json; a="',
    ],
    b"Content-Encoding": [b"gzip", b"identity, gzip", b"\xff", b"", b"br" * 5000, b"IDENTITY"],
    b"Content-Range": [b"bytes 0-1/2", b"x"],
    b"Idempotency-Key": [
        b"", b"x" * 201, b'"', b"\x01", b"\xff", b"\xc3\xa9", b"'; DROP TABLE fits; --", b"../../x", b"a\x00b", b" ",
        b"%00", b"\xf0\x9f\x90\x8e", LONG,
    ],
    b"Accept": [b"model/ply", b"image/svg+xml;q=nan", b"model/ply, application/json;q=0", b"*/*;q=0"],
    b"Expect": [b"100-continue", b"x"],
    b"Content-MD5": [b"x"],
    b"Digest": [b"sha-256=x"],
}  # fmt: skip


def lines() -> list[Case]:
    """Return header lines that are none, and Hosts."""
    livez = b"GET /livez HTTP/1.1\r\n"
    found = [
        Case(
            f"{line[:40]!r} ({len(line)})", (livez + HOST + CLOSE + line + END + END,), REFUSED | TAKEN, may_close=True
        )
        for line in LINES
    ]
    found += [
        Case(f"Host {host[:40]!r}", (livez + b"Host: " + host + END + CLOSE + END,), REFUSED | TAKEN) for host in HOSTS
    ]
    return [
        *found,
        Case("no header at all", (livez + END,)),
        Case("HTTP/1.0 without", (b"GET /livez HTTP/1.0\r\n\r\n",), TAKEN),
    ]


def values() -> list[Case]:
    """Return values of headers that the service reads, or that others read, with a GET."""
    target = b"/v1/fits/" + CURVE
    return [
        Case(
            f"{name.decode()} {value[:40]!r} ({len(value)})",
            (get(target, name + b": " + value + END),),
            REFUSED | TAKEN,
        )
        for name, each in VALUES.items()
        for value in each
    ]


def posted() -> list[Case]:
    """Return the same with a POST; twice the same header, too."""
    found = []
    for name, each in POSTED.items():
        for value in each:
            sent = post(headers=name + b": " + value + END)
            if name == b"Content-Type":
                sent = post(kind=value)
            found.append(Case(f"{name.decode()} {value[:40]!r} ({len(value)})", (sent,), REFUSED | TAKEN))
    twice = post(headers=b"Idempotency-Key: a\r\nIdempotency-Key: b\r\nContent-Type: text/csv\r\n")
    return [*found, Case("headers twice", (twice,), REFUSED | TAKEN)]
