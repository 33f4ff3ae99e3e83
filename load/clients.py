"""Clients that repeat requests as the contract asks for, and record what the servers promised."""

import random
import time
from collections import Counter
from dataclasses import dataclass, field
from threading import Event, Lock
from typing import Any
from uuid import uuid4

import httpx

from tests.service.bodies import ellipse, huge_torus, npy, sphere, torus

# Each fit that is sent: body, query, and its share in percent. The first two take some hundredths of a second, the
# others two or three seconds; the last is split into five parts.
FITS = (
    (npy(ellipse()), "", 50),
    (npy(sphere()), "", 25),
    (npy(torus(3000)), "t1=0&max_degree=8", 11),
    (npy(torus(20_000)), "t1=0&max_degree=8", 4),
    (npy(huge_torus(100_000)), "constraints=5l", 10),
)
FINAL = ("successful", "failed", "dismissed")
# Share of fits that are dismissed again.
DISMISSED = 0.05
# The reasons with which a server may answer 503. `worker-crashed`: two processes were killed while they read one body.
PASSING = {"not-ready", "queue-full", "shutting-down", "worker-crashed"}
# Seconds that a request may take: more than the longest wait that is asked for.
REQUEST_TIMEOUT = 40.0


@dataclass
class Promise:
    """An accepted fit, as a server answered.

    Attributes
    ----------
    kind
        Its index in FITS.
    key
        Its idempotency key.
    fit
        Its id.
    deleted
        Whether a DELETE was sent.
    seen
        The first answer in which it had ended.

    """

    kind: int
    key: str
    fit: str
    deleted: bool = False
    seen: dict[str, Any] | None = None


@dataclass
class Log:
    """What all clients record, shared between their threads."""

    promises: list[Promise] = field(default_factory=list)
    answers: Counter[str] = field(default_factory=Counter)
    unexplained: list[str] = field(default_factory=list)
    lock: Lock = field(default_factory=Lock)
    last: float = field(default_factory=time.monotonic)

    def promised(self, promise: Promise) -> None:
        """Record an accepted fit."""
        with self.lock:
            self.promises.append(promise)
            self.last = time.monotonic()

    def silent(self) -> float:
        """Return the seconds since the last promise."""
        return time.monotonic() - self.last

    def note(self, answer: str) -> None:
        """Count an answer."""
        with self.lock:
            self.answers[answer] += 1


class Caller:
    """A client: sends fits, waits for some of them, and dismisses a few."""

    def __init__(self, number: int, ports: list[int], log: Log, seed: int) -> None:
        self._ports, self._log = ports, log
        self._random = random.Random(seed * 1000 + number)  # noqa: S311 - no secret
        self._client = httpx.Client(timeout=REQUEST_TIMEOUT)

    def work(self, enough: Event) -> None:
        """Send fits until `enough` is set."""
        while not enough.is_set():
            kind = self._random.choices(range(len(FITS)), [share for _, _, share in FITS])[0]
            promise = self._send(kind, enough)
            if promise is not None and self._random.random() < DISMISSED:
                self._dismiss(promise)

    def _send(self, kind: int, enough: Event) -> Promise | None:
        """Send one fit, repeatedly with the same key, until it is accepted."""
        content, query, _ = FITS[kind]
        key = uuid4().hex
        prefer = self._random.choice(("respond-async", "respond-async", "wait=2", "wait=20"))
        headers = {"Content-Type": "application/x-npy", "Prefer": prefer, "Idempotency-Key": f'"{key}"'}
        sent = False
        while sent or not enough.is_set():  # a fit that was sent may be stored: repeat until the answer says so
            sent = True
            answer = self.ask("POST", f"/v1/fits?{query}", content=content, headers=headers)
            if answer is not None and answer.status_code in (200, 202):
                fit = answer.json()
                promise = Promise(kind, key, fit["id"], seen=fit if fit["status"] in FINAL else None)
                self._log.promised(promise)
                return promise
            full = answer is not None and "queue-full" in answer.text
            sent = not full  # the server looks for the key first, so a full queue means that the fit is not stored
            time.sleep(self._random.uniform(0.5, 1.5) if full else self._random.uniform(0.05, 0.3))
        return None

    def _dismiss(self, promise: Promise) -> None:
        time.sleep(self._random.uniform(0.0, 1.0))
        promise.deleted = True
        for _ in range(100):
            answer = self.ask("DELETE", f"/v1/fits/{promise.fit}")
            if answer is not None and answer.status_code in (200, 204, 404):
                return
            time.sleep(0.2)

    def ask(self, method: str, path: str, **more: Any) -> httpx.Response | None:  # noqa: ANN401 - httpx's
        """Send a request to a random server and return the answer, if there is one; record unexplained answers."""
        try:
            answer = self._client.request(method, f"http://127.0.0.1:{self._random.choice(self._ports)}{path}", **more)
        except httpx.TransportError as error:
            self._log.note(f"{method}: no answer ({type(error).__name__})")
            if isinstance(error, httpx.TimeoutException):
                self._log.unexplained.append(f"{method} {path}: {error!r}")
            return None
        problem = _problem(answer)
        self._log.note(f"{method}: {answer.status_code} {problem}".rstrip())
        if not _explained(method, answer, problem):
            self._log.unexplained.append(f"{method} {path}: {answer.status_code} {answer.text[:300]}")
        return answer


def _problem(answer: httpx.Response) -> str:
    """Return the code of an answer that is a problem; `none` if it is an error that has no problem details."""
    if not answer.is_error:
        return ""
    is_problem = answer.headers.get("content-type") == "application/problem+json"
    return str(answer.json()["code"]) if is_problem else "none"


def _explained(method: str, answer: httpx.Response, problem: str) -> bool:
    """Return whether the contract allows this answer while processes are killed."""
    if answer.status_code == httpx.codes.SERVICE_UNAVAILABLE:
        return problem in PASSING and "retry-after" in answer.headers
    if answer.status_code == httpx.codes.NOT_FOUND:
        return method in {"DELETE", "GET"}  # fits that must not be missing are counted as lost later
    return answer.is_success
