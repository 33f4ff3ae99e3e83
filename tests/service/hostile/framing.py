"""Where a request ends: what proxies and servers read differently, and request smuggling uses."""

from tests.service.hostile.cases import BODY, CLOSE, END, HOST, REFUSED, TAKEN, Case, cases

POST = b"POST /v1/fits HTTP/1.1\r\n" + HOST
SMUGGLED = b"GET /smuggled HTTP/1.1\r\nHost: x\r\n\r\n"
CHUNKED = b"Transfer-Encoding: chunked\r\n"

# Two statements about the length, or one that is none.
LENGTHS = [
    b"+5", b"-1", b"5,5", b"5, 6", b"0x5", b"5 5", b"5.0", b"1e1", b"", b"five", b"5;", b"\xef\xbc\x95", b"5\x00",
    b"'5'", b"99999999999999999999", b"18446744073709551616", b"18446744073709551615", b"9223372036854775808",
]  # fmt: skip
ENCODINGS = [
    b"Transfer-Encoding: xchunked", b"Transfer-Encoding : chunked", b"Transfer-Encoding:\tchunked",
    b"Transfer-Encoding: chunked, identity", b"Transfer-Encoding: identity", b"Transfer-Encoding: gzip, chunked",
    b"Transfer-Encoding: chunked\r\nTransfer-Encoding: x", b"Transfer-Encoding: x\r\nTransfer-Encoding: chunked",
    b"X: y\r\n Transfer-Encoding: chunked", b"Transfer-Encoding: \x0bchunked", b"Transfer_Encoding: chunked",
    b"Transfer-Encoding: 'chunked'", b"Transfer-Encoding: chunked;q=1", b"transfer-ENCODING: CHUNKED",
    b"Transfer-Encoding\x00: chunked", b" Transfer-Encoding: chunked", b"Transfer-Encoding: \x00chunked",
    b"Transfer-Encoding:\r\n chunked", b"X: y\nTransfer-Encoding: chunked", b"Transfer-Encoding: chunked\r",
]  # fmt: skip
# What stands in the place of the size line of a chunk, and of the end of its data.
SIZES = [
    b"0x2\r\n", b"+2\r\n", b"-2\r\n", b"2 \r\n", b" 2\r\n", b"2\n", b"2\r", b"2;\n", b"\r\n2\r\n", b"2,2\r\n",
    b"02;a=b\r\n", b"g\r\n", b"ffffffffffffffff\r\n", b"10000000000000000\r\n", b"10000000000000002\r\n",
    b"0" * 100 + b"2\r\n", b"2;" + b"a" * 5000 + b"\r\n", b'2;a="\r\n"\r\n', b"2;a\x00b\r\n", b"2\r\n\r\n",
    b"\xef\xbc\x92\r\n",
]  # fmt: skip
DATA = [b"{}", b"{}X\r\n", b"{}\n", b"{}\r", b"{\r\n", b"{}}\r\n"]
LINES = {
    "bare LF": b"POST /v1/fits HTTP/1.1\nHost: x\nContent-Length: 0\n\n",
    "bare LF in the end": POST + b"Content-Length: 0\r\n\n",
    "bare CR": b"POST /v1/fits HTTP/1.1\rHost: x\rContent-Length: 0\r\r",
    "CR CR LF": b"POST /v1/fits HTTP/1.1\r\r\nHost: x\r\r\n\r\r\n",
    "folded": b"GET /livez HTTP/1.1\r\nHost: x\r\nX: a\r\n b\r\nConnection: close\r\n\r\n",
    "folded by a tab": b"GET /livez HTTP/1.1\r\nHost: x\r\nX: a\r\n\tb\r\nConnection: close\r\n\r\n",
    "folded Host": b"GET /livez HTTP/1.1\r\nHost:\r\n x\r\nConnection: close\r\n\r\n",
    "fold before the first header": b"GET /livez HTTP/1.1\r\n Host: x\r\nHost: x\r\n\r\n",
    "blank lines before": b"\r\n" * 20 + b"GET /livez HTTP/1.1\r\n" + HOST + CLOSE + END,
    "no blank line after, and closed": POST + b"Content-Length: 2\r\n{}",
    "LF in a value": b"GET /livez HTTP/1.1\r\nHost: x\r\nX: a\nb: c\r\n" + CLOSE + END,
}  # fmt: skip


def _length_and_encoding() -> list[Case]:
    """Return requests with both, in both orders: the body ends in two places."""
    body = b"0\r\n\r\n" + SMUGGLED
    length = b"Content-Length: %d\r\n"
    both = {
        "CL.TE": POST + length % len(body) + CHUNKED + END + body,
        "TE.CL": POST + CHUNKED + length % len(body) + END + body,
        "CL.TE short": POST + length % 4 + CHUNKED + END + b"5c\r\n" + SMUGGLED + b"0\r\n\r\n",
        "CL.CL": POST + length % 2 + length % (2 + len(SMUGGLED)) + END + b"{}" + SMUGGLED,
        "CL.CL alike": POST + length % 2 + length % 2 + CLOSE + END + b"{}" + SMUGGLED,
        "CL.0": b"GET /livez HTTP/1.1\r\n" + HOST + CLOSE + length % len(SMUGGLED) + END + SMUGGLED,
        "TE.0": b"GET /livez HTTP/1.1\r\n" + HOST + CLOSE + CHUNKED + END + b"25\r\n" + SMUGGLED + b"\r\n0\r\n\r\n",
        "HTTP/1.0 TE": b"POST /v1/fits HTTP/1.0\r\n" + CHUNKED + END + b"0\r\n\r\n" + SMUGGLED,
        "close, then another": b"GET /livez HTTP/1.1\r\n" + HOST + CLOSE + END + SMUGGLED,
    }
    return cases(both, REFUSED | TAKEN, may_close=True)


def smuggling() -> list[Case]:
    """Return requests whose end is said twice or unclearly; what follows must never be answered as a request."""
    found = _length_and_encoding()
    for value in LENGTHS:
        sent = POST + CLOSE + b"Content-Length: " + value + END + END + b"{}   " + SMUGGLED
        found.append(Case(f"Content-Length {value!r}", (sent,), REFUSED, may_close=True))
    for line in ENCODINGS:
        sent = POST + CLOSE + b"Content-Length: 5\r\n" + line + END + END + b"0\r\n\r\n" + SMUGGLED
        found.append(Case(f"{line!r}", (sent,), REFUSED, may_close=True))
    return found


def chunks() -> list[Case]:
    """Return chunked bodies that are wrong, and some that are only strange."""
    begin = POST + CLOSE + CHUNKED + END
    found = [
        Case(f"size {size[:30]!r}", (begin + size + b"{}\r\n0\r\n\r\n" + SMUGGLED,), may_close=True) for size in SIZES
    ]
    found += [
        Case(f"data {data!r}", (begin + b"2\r\n" + data + b"0\r\n\r\n" + SMUGGLED,), may_close=True) for data in DATA
    ]
    each = b"".join(b"1;a=%d\r\n%c\r\n" % (i, byte) for i, byte in enumerate(BODY))
    strange = {
        "one byte each": begin + each + b"0\r\n\r\n",
        "trailers": begin + b"%x\r\n%b\r\n0\r\nContent-Length: 0\r\nHost: y\r\nX: y\r\n\r\n" % (len(BODY), BODY),
        "many trailers": begin + b"2\r\n{}\r\n0\r\n" + b"a: b\r\n" * 3000 + END,
        "a long trailer": begin + b"2\r\n{}\r\n0\r\na: " + b"b" * 70_000 + END + END,
        "an extension of 200 kB": begin + b"2;" + b"a" * 200_000 + END + b"{}\r\n0\r\n\r\n",
        "no last chunk, and closed": begin + b"2\r\n{}\r\n",
        "nothing": begin + b"0\r\n\r\n",
    }
    found += [Case(name, (sent,), REFUSED | TAKEN, may_close=True, half_close=True) for name, sent in strange.items()]
    return found


def lines() -> list[Case]:
    """Return requests whose lines end as they must not, or are folded."""
    return [Case(n, (s,), REFUSED | TAKEN, may_close=True, half_close="closed" in n) for n, s in LINES.items()]
