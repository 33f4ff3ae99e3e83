"""Random requests, valid and not, and sequences of them along the links of the OpenAPI document.

None gets a 500, and every response agrees with the document: all checks of schemathesis are on.
"""

import os
import random
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from service.api_keys import new_key
from tests.service.bodies import ellipse, npy, sphere
from tests.service.running import COMMAND, Server

HERE = Path(__file__).parent
LEAST_LINKS = 8  # of 21; how many requests fit into the time decides which are followed
QUICK = settings(
    max_examples=12,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


def test_every_operation_keeps_to_the_document(start: Callable[..., Server], tmp_path: Path) -> None:
    key, entry = new_key("fuzzer")
    (tmp_path / "keys.toml").write_text(entry, encoding="utf-8")
    server = start(MAX_WAIT=3, API_KEYS=tmp_path / "keys.toml")
    done = subprocess.run(  # noqa: S603 - a program of this environment
        [
            *(COMMAND.with_name("schemathesis"), "--config-file", HERE / "schemathesis.toml", "run"),
            *(f"{server.url}/openapi.json", "--checks", "all", "--max-time", "60", "--max-examples", "30"),
            *("--header", f"Authorization: Bearer {key}"),
            # tests.service.fuzz_hooks has a check in place of this one
            *("--exclude-checks", "use_after_free", "--no-color", "--request-timeout", "60"),
        ],
        cwd=tmp_path,  # where it leaves its findings
        env={**os.environ, "PYTHONPATH": str(HERE.parents[1])},
        capture_output=True,
        text=True,
        timeout=240.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in server.log, server.log.partition("Traceback")
    for phase in ("Examples", "Coverage", "Fuzzing", "Stateful"):
        assert f"✅ {phase}" in done.stdout.partition("Test Phases")[2], done.stdout
    covered = re.search(r"API Links: +(\d+) covered", done.stdout)
    assert covered is not None, done.stdout
    assert int(covered.group(1)) >= LEAST_LINKS, done.stdout
    server.stop()


@pytest.mark.parametrize("kind", ["application/json", "application/x-npy", "text/plain"])
@settings(QUICK, max_examples=100)
@given(
    body=st.binary(max_size=300),
    headers=st.dictionaries(
        st.sampled_from(["Accept", "Prefer", "Content-Encoding", "traceparent", "If-None-Match"]),
        st.text(st.characters(min_codepoint=0x20, max_codepoint=0x7E), max_size=30).map(str.strip),
    ),
)
def test_no_bytes_break_it(client: httpx.Client, kind: str, body: bytes, headers: dict[str, str]) -> None:
    answer = client.post("/v1/fits", content=body, headers={**headers, "Content-Type": kind})
    assert 400 <= answer.status_code < 500
    assert answer.headers["Content-Type"] == "application/problem+json"


@settings(QUICK, max_examples=30)
@given(st.integers(0, 2**32), st.floats(-300.0, 300.0), st.floats(-300.0, 300.0))
def test_points_of_every_size_and_place_are_fitted_or_refused(
    client: httpx.Client, seed: int, scale: float, move: float
) -> None:
    generator = random.Random(seed)  # noqa: S311 - no secret
    table = generator.choice([ellipse(30), sphere(60)[:, :3]])
    signs = [generator.choice([-1.0, 0.0, 1.0]) for _ in range(table.shape[1])]
    moved = table * 10.0**scale + [sign * 10.0**move for sign in signs]
    headers = {"Content-Type": "application/x-npy"}
    answer = client.post("/v1/fits?max_degree=3", content=npy(moved), headers=headers)
    assert answer.status_code in (200, 422), answer.json()
    if answer.status_code == 200:
        assert answer.json()["status"] == "successful", answer.json()
