"""Request lines: methods, targets and versions, and what is no HTTP at all."""

from tests.service.hostile.cases import CLOSE, END, HOST, REFUSED, SURFACE, TAKEN, UNKNOWN, Case, cases, get

REST = HOST + CLOSE + END
KNOWN = [
    "GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "QUERY", "PROPFIND", "LOCK", "PURGE",
    "SOURCE",
]  # fmt: skip
METHODS = [*KNOWN, "CONNECT", "BREW", "get", "Get", "G", '"GET"', "GET\x01", "GÉT", "GET" * 25, "PRI", "DEBUG"]
PATHS = [
    "/", "/livez", "/readyz", "/docs", "/docs/assets/x", "/openapi.json", "/v1/fits", "/v1/fits/x/mesh", "/nothing",
    "*",
]  # fmt: skip

LINES = [
    b"GET", b"GET ", b"GET /livez", b"GET /livez HTTP", b"GET /livez HTTP/", b"GET /livez HTTP/1",
    b"GET /livez HTTP/1.", b"GET /livez HTTP/2.0", b"GET /livez HTTP/0.9", b"GET /livez HTTP/1.9",
    b"GET /livez HTTP/11.1", b"GET /livez HTTP/1.1 ", b"GET /livez HTTP/1.1 x", b"GET  /livez HTTP/1.1",
    b"GET /livez  HTTP/1.1", b"GET\t/livez\tHTTP/1.1", b" GET /livez HTTP/1.1", b"GET /livez http/1.1",
    b"GET /livez ICE/1.0", b"GET /livez RTSP/1.0", b"GET /livez HTTPS/1.1", b"GET /li vez HTTP/1.1",
    b"GET livez HTTP/1.1", b"GET  HTTP/1.1", b"GET ? HTTP/1.1", b"GET # HTTP/1.1", b"GET /livez#x HTTP/1.1",
    b"GET /\x00 HTTP/1.1", b"GET /\x7f HTTP/1.1", b"GET /\xff\xfe HTTP/1.1", b"GET /\xc3\xa9 HTTP/1.1",
    b"GET /<> HTTP/1.1", b"GET \\livez HTTP/1.1", b"GET /livez\r HTTP/1.1", b"/livez", b"", b"HTTP/1.1 200 OK",
    b"GET /livez HTTP/-1.1", b"GET /livez HTTP/1.1\x00", b"GET /livez HTTP/\xef\xbc\x91.1",
]  # fmt: skip
TARGETS = [
    "http://x/livez", "http://other:99999/livez", "https://x/livez", "HTTP://X/livez", "http://", "http:///livez",
    "http://[::1/livez", "http://[::1]:0/livez", "http://u:p@x/livez", "http://x:-1/livez", "ftp://x/livez",
    "file:///livez", "x:443", "//livez", "//x/livez", "javascript:alert(1)", "/livez?", "/livez??", "/livez/",
    "/livez;x", "/./livez", "/../livez", "/x/../livez", "/%2e%2e/livez", "/livez%", "/livez%0", "/livez%zz",
    "/livez%00", "/%00", "/%ff%fe", "/%c0%af", "/%ed%a0%80", "/%u002f", "/livez%2f", "/%2flivez", "/%0d%0aX:%20y",
    "/livez%20HTTP/1.1%0d%0a", "/%F0%9F%90%8E", "/docs/assets/../../../livez", "/docs/assets/..%2f..%2f__init__.py",
    "/docs/assets/%2e%2e/%2e%2e/__init__.py", "/docs/assets/....//....//etc/passwd", "/docs/assets//etc/passwd",
    "/docs/assets/%00", "/docs/assets/..%5c..%5c__init__.py", "/docs/assets/", "/docs/assets", "/docs/assets/%ff",
    "/docs/assets/" + "a/" * 3000, "/docs/assets/" + "a" * 300, "/docs/assets/" + "%25" * 3000,
    "/v1/fits/../../livez", "/v1//fits", "/V1/FITS", "/v1/fits/", "/" + "a" * 60_000, "/" + "%61" * 20_000,
    "/" + "a/" * 30_000, "/" + "../" * 20_000,
]  # fmt: skip
PROTOCOLS = {
    "the preface of HTTP/2": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes(9),
    "a TLS hello": bytes.fromhex("1603010200010001fc0303") + bytes(502),
    "an SSL 2 hello": bytes.fromhex("802e0100020015000000100100800200800300800600") + bytes(30),
    "a SOCKS request": b"\x05\x01\x00", "an SSH banner": b"SSH-2.0-x\r\n", "a Redis command": b"*1\r\n$4\r\nPING\r\n",
    "SMTP": b"EHLO x\r\nMAIL FROM:<x@x>\r\n",
    "the proxy protocol": b"PROXY TCP4 1.2.3.4 1.2.3.4 1 2\r\nGET /livez HTTP/1.1\r\n" + REST,
    "the proxy protocol 2": b"\r\n\r\n\x00\r\nQUIT\n" + bytes(16), "zeros": bytes(100_000), "ones": b"\xff" * 100_000,
    "blanks": b" " * 100_000, "line ends": b"\r\n" * 100_000 + b"x\r\n\r\n", "letters": b"a" * 100_000,
    "a pickle": b"\x80\x04\x95\x1e\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94\x8c\x06system\x94\x93\x94.",
}  # fmt: skip


def methods() -> list[Case]:
    """Return every method at every path: known or not, in any spelling."""
    found = []
    for method in METHODS:
        for path in PATHS:
            sent = get(path, b"Content-Length: 0\r\n", method.encode())
            taken = method in KNOWN
            statuses = (REFUSED | TAKEN) if taken else UNKNOWN
            found.append(Case(f"{method[:20]} {path}", (sent,), statuses, bodiless=method == "HEAD"))
    return found


def request_lines() -> list[Case]:
    """Return request lines that are none, or none of HTTP/1.1."""
    return [
        Case(
            f"{line!r}", (line + END + HOST + CLOSE + END,), UNKNOWN | TAKEN, may_close=True, half_close=True, answers=2
        )
        for line in LINES
    ]


def targets() -> list[Case]:
    """Return targets with wrong escapes, dots, other forms, and of great length."""
    found = [Case(f"{t[:60]} ({len(t)})", (get(t),), REFUSED | TAKEN) for t in TARGETS]
    found += [
        Case(f"DELETE {t}", (get(t, b"", b"DELETE"),)) for t in ("/v1/fits/" + "0" * 32, "/v1/fits/%00", "/v1/fits/..")
    ]
    deep = b"/v1/fits/" + SURFACE + b"/../" + SURFACE + b"/mesh"
    return [*found, Case("dots between ids", (get(deep),))]


def protocols() -> list[Case]:
    """Return the first bytes of other protocols."""
    return cases(PROTOCOLS, UNKNOWN, may_close=True)
