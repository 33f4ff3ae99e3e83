"""Random requests, valid and not: none gets a 500, and every response agrees with the OpenAPI document."""

import random
from typing import Any

import httpx
import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from service.bootstrap import application
from service.settings import Settings
from tests.service.bodies import ellipse, npy, sphere

schemathesis.serializer.alias("application/x-npy", "application/octet-stream")
SCHEMA = schemathesis.openapi.from_dict(application(Settings()).openapi())
CHECKS = (not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance)
QUICK = settings(
    max_examples=12,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


@SCHEMA.parametrize()
@QUICK
def test_every_operation_keeps_to_the_document(case: Any, server: str) -> None:  # noqa: ANN401 - schemathesis's own
    case.call_and_validate(base_url=server, checks=CHECKS, headers={"Prefer": "wait=5"})


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
