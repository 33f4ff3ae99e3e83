"""A user for Locust: sends one request after another, each when the one before is answered (a closed loop).

`load.loops.closed` runs it in a process of its own, with two variables: TRAFFIC, a file with the pickled requests, and
ANSWERS, the file to which the time, the status and the seconds of each answer go.
"""

import os
import pickle
import time
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from random import Random
from typing import Any

from locust import FastHttpUser

from load.loops.traffic import NPY, Request

REQUESTS: list[Request] = pickle.loads(Path(os.environ["TRAFFIC"]).read_bytes())  # noqa: S301 - written by load.loops.closed
ANSWERS = Path(os.environ["ANSWERS"]).open("w", encoding="utf-8", buffering=1)  # noqa: SIM115 - open until the end
NUMBERS = count()


def chosen(number: int) -> Iterator[Request]:
    """Yield the requests of one user: each as often as its share says; meshes in turn, so that none comes twice."""
    if REQUESTS[0].method == "GET":
        yield from (REQUESTS[at % len(REQUESTS)] for at in NUMBERS)
    random = Random(number)  # noqa: S311 - no secret
    while True:
        yield from random.choices(REQUESTS, [one.share for one in REQUESTS], k=100)


def begin(user: Any) -> None:  # noqa: ANN401 - a class of Locust, which is not always installed
    """Begin with a choice of its own."""
    user.requests = chosen(next(NUMBERS))


def ask(user: Any) -> None:  # noqa: ANN401 - as above
    """Send the next request and note its answer."""
    one = next(user.requests)
    headers = {"Content-Type": NPY} if one.body else {}
    with user.client.request(
        one.method, one.path, data=one.body or None, headers=headers, catch_response=True
    ) as answer:
        took = answer.request_meta["response_time"] / 1000.0
        ANSWERS.write(f"{time.time():.4f} {answer.status_code} {took:.4f}\n")
        answer.success()


# One client with one connection.
LIMITS = {"connection_timeout": 60.0, "network_timeout": 120.0}
User = type("User", (FastHttpUser,), LIMITS | {"on_start": begin, "tasks": [ask]})
