"""Whole requests that nobody means, to a server: bodies by the grammars of the formats, with options, ids and bounds.

Ten seconds, or ten times IPFIT_FUZZ_SECONDS. A failure names the seed that makes the same request again.
"""

import os
import random
import time

import httpx
import pytest

from service.options import FitOptions
from tests.service.grammars.draws import Generator
from tests.service.running import Server
from tests.service.test_fuzz_points import GRAMMARS, damaged

SECONDS = 10.0 * float(os.environ.get("IPFIT_FUZZ_SECONDS", "1"))
MEDIA_TYPES = {"json": "application/json", "npy": "application/x-npy", "csv": "text/csv"}
NUMBERS = [
    "0", "1", "-1", "2", "3", "40", "41", "0.5", "1e-300", "1e308", "-1e308", "inf", "nan", "1e999", "true", "", " ",
    "9223372036854775808", "0x10", "1_0", "é", "%00", "null", "[]", "1,2", "'", "-0.0", "\uff15",
]  # fmt: skip
WORDS = [
    "3l",
    "5l",
    "taubin",
    "distance",
    "gcv",
    "none",
    "full",
    "monomial",
    "chebyshev",
    "block",
    "paper",
    "true",
    "false",
]
ACCEPTED = ["*/*", "application/json", "model/ply", "image/svg+xml;q=0.5, */*;q=0", "q=", "a/b/c", ",,,", "*/json", "é"]


def options(r: Generator) -> dict[str, str]:
    """Return a query of options, mostly of values that are not allowed, and always of a low degree."""
    names = r.sample([*FitOptions.model_fields, "format", "columns", "missing", "nothing"], r.choice([0, 0, 1, 2, 5]))
    return {name: r.choice(NUMBERS + WORDS) for name in names} | {"max_degree": r.choice(["1", "2", "3"])}


def bounds(r: Generator) -> str:
    return ",".join(r.choice(NUMBERS) for _ in range(r.choice([0, 1, 4, 4, 4, 6, 6, 6, 7])))


def post(client: httpx.Client, r: Generator) -> httpx.Response:
    kind = r.choice(list(MEDIA_TYPES))
    headers = {
        "Content-Type": r.choice([MEDIA_TYPES[kind], MEDIA_TYPES[kind], "text/plain", "a", ""]),
        "Prefer": r.choice(["wait=20", "wait=20", "respond-async", "wait=-1", "wait=é", "return=minimal"]),
        "Accept": r.choice(ACCEPTED),
        "Idempotency-Key": r.choice(["a", "b" * 200, "c" * 201, '"d"', "é"]),
    }
    sent = {name.encode(): headers[name].encode() for name in r.sample(sorted(headers), r.choice([1, 2, 4]))}
    return client.post("/v1/fits", params=options(r), content=damaged(GRAMMARS[kind](r), r), headers=sent)


def look(client: httpx.Client, r: Generator, fits: list[str]) -> httpx.Response:
    fit = r.choice([*fits, "%00", "a" * 32, "0" * 5000, "..%2f..%2f", "%F0%9F%90%8E", "'", "%"])
    if r.random() < 0.3:
        return client.request(r.choice(["GET", "HEAD", "DELETE", "PUT", "OPTIONS", "PATCH"]), f"/v1/fits/{fit}")
    asked = {
        "bounds": bounds(r),
        "resolution": r.choice([*NUMBERS, "16", "32"]),
        "extent": r.choice(["data", "bounds", "x"]),
    }
    asked["format"] = r.choice(["ply", "glb", "stl", "obj", "svg", "geojson", "é", ""])
    return client.get(
        f"/v1/fits/{fit}/mesh",
        params={name: asked[name] for name in r.sample(sorted(asked), r.choice([1, 2, 4]))},
        headers={b"Accept": r.choice(ACCEPTED).encode()},
    )


@pytest.mark.timeout(20.0 * SECONDS + 100.0)
def test_no_request_is_answered_with_an_error_of_the_server(shared: Server) -> None:
    client, end, seed, fits = shared.client, time.monotonic() + SECONDS, 0, [""] * 2
    while time.monotonic() < end:
        seed += 1
        r = random.Random(seed)  # noqa: S311 - no secret
        answer = look(client, r, fits) if r.random() < 0.5 else post(client, r)
        assert answer.status_code < 500 or answer.status_code == 503, (seed, answer.text)
        is_json = answer.headers.get("content-type") == "application/json" and answer.content
        if answer.status_code in {200, 202} and is_json:
            fit = answer.json()
            fits[r.randrange(2)] = fit.get("id", "")
            wrong = fit.get("problem") or {"type": ""}
            assert wrong["type"] in {"", "/problems/fit-error"}, (seed, wrong)
    assert seed > 10
    assert client.get("/readyz").status_code == 200
