"""The requests of attackers, as bytes."""

import json

from tests.service.bodies import ellipse, huge_torus, npy

HOST = b"Host: x\r\n"
LIVEZ = b"GET /livez HTTP/1.1\r\n" + HOST + b"\r\n"
LIVEZ_ONCE = b"GET /livez HTTP/1.1\r\n" + HOST + b"Connection: close\r\n\r\n"
HALF_HEAD = b"GET /livez HTTP/1.1\r\n" + HOST + b"X: "
HALF_BODY = b"POST /v1/fits HTTP/1.1\r\n" + HOST + b"Content-Length: 1000000\r\n\r\n["
LARGE_HEAD = (
    b"GET /livez HTTP/1.1\r\n" + HOST + b"".join(b"X-%d: %s\r\n" % (i, b"x" * 230) for i in range(250)) + b"\r\n"
)


def post(body: bytes, kind: str, query: str = "", *, prefer: str = "respond-async") -> bytes:
    """Return a request to fit, after whose answer the connection is closed."""
    head = f"POST /v1/fits?{query} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nPrefer: {prefer}\r\n"
    head += f"Content-Type: {kind}\r\nContent-Length: {len(body)}\r\n\r\n"
    return head.encode() + body


def mesh(fit: str, resolution: int, *, close: bool) -> bytes:
    """Return a request for the zero set of a fit."""
    head = f"GET /v1/fits/{fit}/mesh?format=obj&extent=bounds&resolution={resolution} HTTP/1.1\r\nHost: x\r\n"
    return (head + ("Connection: close\r\n" if close else "") + "\r\n").encode()


def _with_keys(count: int) -> bytes:
    return json.dumps({f"key {i}": i for i in range(count)}).encode()


JSON, NPY = "application/json", "application/x-npy"
SMALL_CHUNKS = (
    b"POST /v1/fits HTTP/1.1\r\n"
    + HOST
    + b"Transfer-Encoding: chunked\r\n\r\n"
    + b"1\r\n \r\n" * 100_000
    + b"0\r\n\r\n"
)
BROKEN_JSON = post(b'{"points": [' + b"[1.0,2.0]," * 100_000 + b"[1.0", JSON)
MANY_POINTS = post(npy(huge_torus(21_000)), NPY, "max_degree=2&geometric=false")
MANY_KEYS = post(_with_keys(12_000), JSON)
MORE_KEYS = post(_with_keys(220_000), JSON)
SMALL_FIT = post(npy(ellipse(60)), NPY)
