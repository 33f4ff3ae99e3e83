"""A client that does nothing wrong: it asks for `/livez` every 20 ms and sends one small fit after another.

It runs in a process of its own, `python -m load.victim PORT SECONDS`, and prints what it measured as JSON.
"""

import http.client
import json
import sys
import time
from dataclasses import asdict, dataclass, field
from threading import Thread

from tests.service.bodies import ellipse, npy

# Not the address of the attackers, and not one of those whose X-Forwarded-For is believed.
ADDRESS = "127.0.0.2"
LIVEZ_SECONDS = 0.02  # between the starts of two requests
FIT = npy(ellipse(60))
TIMEOUT = 30.0


@dataclass
class Measured:
    """What the client saw: seconds of each answer, and how many answers were none or no success."""

    livez: list[float] = field(default_factory=list)
    fits: list[float] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)


def measure(port: int, seconds: float) -> Measured:
    """Measure for so many seconds."""
    found, end = Measured(), time.monotonic() + seconds
    threads = [Thread(target=work, args=(port, found, end)) for work in (_livez, _fits)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return found


def _livez(port: int, found: Measured, end: float) -> None:
    """Ask every 20 ms, each time over a new connection, as a supervisor does."""
    at = time.monotonic()
    while at < end:
        began = time.monotonic()
        answer = _ask(port, "GET", "/livez")
        if answer != "200":
            found.refused.append(f"livez {answer}")
        found.livez.append(time.monotonic() - began)
        at = max(at + LIVEZ_SECONDS, time.monotonic())
        time.sleep(max(0.0, at - time.monotonic()))


def _fits(port: int, found: Measured, end: float) -> None:
    while time.monotonic() < end:
        began = time.monotonic()
        answer = _ask(port, "POST", "/v1/fits", FIT)
        if answer == "200":
            found.fits.append(time.monotonic() - began)
        else:
            found.refused.append(f"fit {answer}")
            time.sleep(LIVEZ_SECONDS)


def _ask(port: int, method: str, path: str, body: bytes | None = None) -> str:
    """Return the status of an answer, or the name of the error in its place."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=TIMEOUT, source_address=(ADDRESS, 0))
    try:
        connection.request(method, path, body, {"Content-Type": "application/x-npy"} if body else {})
        answer = connection.getresponse()
        answer.read()
    except (OSError, http.client.HTTPException) as error:
        return type(error).__name__
    else:
        return str(answer.status)
    finally:
        connection.close()


if __name__ == "__main__":
    print(json.dumps(asdict(measure(int(sys.argv[1]), float(sys.argv[2])))))
