"""A hostile request: the bytes that are sent, how they are sent, and what may be answered."""

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace

HOST = b"Host: x\r\n"
CLOSE = b"Connection: close\r\n"
END = b"\r\n"
JSON, NPY, CSV = "application/json", "application/x-npy", "text/csv"
# Points of a fit that takes some hundredths of a second.
POINTS = [[2, 0], [1.4, 0.7], [0, 1], [-1.4, 0.7], [-2, 0], [-1.4, -0.7], [0, -1], [1.4, -0.7]]
BODY = json.dumps({"points": POINTS, "options": {"max_degree": 2}}).encode()
# The ids of a fit in 2D and of one in 3D stand in their places when a request is sent.
CURVE, SURFACE = b"<CURVE>", b"<SURFACE>"

# Statuses of requests that are not carried out, and of requests that may be.
REFUSED = frozenset({400, 404, 405, 406, 408, 413, 415, 422, 431})
UNKNOWN = REFUSED | {501}
TAKEN = frozenset({200, 202, 204, 304, 307})  # 307: from the root to the documentation
ANY = REFUSED | TAKEN | {409, 503}


@dataclass(frozen=True)
class Case:
    """A request, or a few on one connection.

    Attributes
    ----------
    name
        Unique in its family.
    pieces
        What is sent, one after the other with a pause between.
    statuses
        Those that may be answered.
    answers
        How many answers may come, at most.
    may_close
        Whether the server may close without an answer.
    half_close
        Whether the client says after the last piece that nothing more comes.
    bodiless
        Whether it is a HEAD request, whose answer has no body.

    """

    name: str
    pieces: tuple[bytes, ...]
    statuses: frozenset[int] = REFUSED
    answers: int = 1
    may_close: bool = False
    half_close: bool = False
    bodiless: bool = False

    def aimed(self, fits: dict[bytes, str]) -> "Case":
        """Return the case with the ids of fits that exist."""
        pieces = self.pieces
        for place, fit in fits.items():
            pieces = tuple(piece.replace(place, fit.encode()) for piece in pieces)
        return replace(self, pieces=pieces)


def get(target: bytes | str, headers: bytes = b"", method: bytes = b"GET") -> bytes:
    """Return a request without a body, after which the connection is closed."""
    target = target if isinstance(target, bytes) else target.encode()
    return method + b" " + target + b" HTTP/1.1\r\n" + HOST + CLOSE + headers + END


def post(body: bytes = BODY, kind: str | bytes = JSON, query: str | bytes = "", headers: bytes = b"") -> bytes:
    """Return a request to fit, after which the connection is closed; it does not wait for the fit."""
    kind, query = (one if isinstance(one, bytes) else one.encode() for one in (kind, query))
    head = b"POST /v1/fits?" + query + b" HTTP/1.1\r\n" + HOST + CLOSE + b"Prefer: respond-async\r\n"
    length = b"Content-Length: %d\r\n" % len(body)
    return head + b"Content-Type: " + kind + END + length + headers + END + body


def cases(sent: dict[str, bytes], statuses: Iterable[int] = REFUSED, *, may_close: bool = False) -> list[Case]:
    """Return a case for each of these requests."""
    return [Case(name, (one,), frozenset(statuses), may_close=may_close) for name, one in sent.items()]
