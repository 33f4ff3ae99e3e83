"""Tables over HTTP, and bodies that once broke the reader: each gets an answer that says what to do."""

import json

import httpx
import numpy as np
import pytest

from service.api.body import IN_MEMORY_BYTES
from tests.service.bodies import ellipse, npy

CSV = {"Content-Type": "text/csv"}
QUICK = "max_degree=2&measure_zero_set=false"
ROWS = [f"{x!r},{y!r}" for x, y in ellipse(60).tolist()]


def send(client: httpx.Client, body: bytes | str, query: str = "", kind: str = "text/csv") -> httpx.Response:
    return client.post(f"/v1/fits?{QUICK}&{query}", content=body, headers={"Content-Type": kind})


@pytest.mark.parametrize("query", ["", "format=csv"])
@pytest.mark.parametrize("header", ["", "x,y\n", "# x y\n", "﻿X,Y\n"])
def test_a_table_is_fitted(client: httpx.Client, query: str, header: str) -> None:
    kind = "text/csv" if not query else "application/octet-stream"
    answer = send(client, header + "\n".join(ROWS), query, kind)
    assert answer.status_code == 200, answer.text
    assert answer.json()["points"] == 60
    assert answer.json()["polynomial"]["degree"] == 2


def test_what_columns_hold_can_be_said(client: httpx.Client) -> None:
    table = [f"{row},{i}.5,7" for i, row in enumerate(ROWS)]
    refused = send(client, "\n".join(table))
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["pointer"] == "/columns"
    assert "columns=x,y,z,_" in refused.text
    assert send(client, "\n".join(table), "columns=x,y,_,_").json()["dimension"] == 2


@pytest.mark.parametrize("query", ["columns=x,y,z,_", "columns=_,x,y,_"])
def test_what_columns_of_an_npy_hold_can_be_said(client: httpx.Client, query: str) -> None:
    generator = np.random.default_rng(0)
    table = np.hstack([generator.normal(size=(60, 3)), np.full((60, 1), 99.0)])
    assert send(client, npy(table), kind="application/x-npy").status_code == 422
    assert send(client, npy(table), f"{query}&geometric=false", "application/x-npy").status_code == 200


@pytest.mark.parametrize("query", ["columns=x,y,q", "columns=", "columns=x,y,z", "missing=guess", "missing="])
def test_wrong_ways_to_read_are_refused(client: httpx.Client, query: str) -> None:
    answer = send(client, "\n".join(ROWS), query)
    assert answer.status_code == 422
    assert query.split("=", maxsplit=1)[0] in answer.text


@pytest.mark.parametrize("repeats", [1, 200])
def test_missing_values_are_refused_with_their_line_or_left_out(client: httpx.Client, repeats: int) -> None:
    rows = ROWS * repeats
    rows[-3] = "1.0,"
    body = "\n".join(rows)
    assert (len(body) > IN_MEMORY_BYTES) == (repeats > 1)  # a large body is read in another process
    refused = send(client, body)
    assert refused.status_code == 422
    assert f"line {len(rows) - 2}, column 2 is missing" in refused.text
    answer = send(client, body, "missing=drop&geometric=false")
    assert answer.status_code in (200, 202), answer.text
    assert answer.json()["points"] == len(rows) - 1


@pytest.mark.parametrize("body", ["", "x,y\n", "1,2\n3\n", "a,b\n1,2\n", '"', "\x00", "1" * 100_000])
def test_a_table_that_is_none_is_refused(client: httpx.Client, body: str) -> None:
    answer = send(client, body)
    assert answer.status_code in (400, 422)
    assert answer.headers["Content-Type"] == "application/problem+json"


@pytest.mark.parametrize("depth", [100, 257, 300, 600, 1000, 2000])
@pytest.mark.parametrize("member", ["points", "normals", "options", "other"])
def test_json_of_any_depth_gets_an_answer(client: httpx.Client, depth: int, member: str) -> None:
    for nest in ("[" * depth + "1" + "]" * depth, '{"a":' * depth + "1" + "}" * depth):
        members = {"points": json.dumps(ellipse(20).tolist())} | {member: nest}
        body = "{" + ",".join(f'"{name}": {value}' for name, value in members.items()) + "}"
        answer = send(client, body, kind="application/json")
        assert answer.status_code in (400, 422), answer.text


@pytest.mark.parametrize("shape", [[0, 2**63], [0, 2**62], [True, 2], [2**63, 0], [2**62, 2], [0, 0], [-1, 2]])
@pytest.mark.parametrize("kind", ["application/json", "application/x-npy"])
def test_a_shape_that_lies_gets_an_answer(client: httpx.Client, shape: list[int], kind: str) -> None:
    if kind == "application/json":
        body = json.dumps({"points": {"dtype": "<f8", "shape": shape, "data": ""}}).encode()
    else:
        literal = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {tuple(shape)}, }}\n".encode()
        body = b"\x93NUMPY\x01\x00" + len(literal).to_bytes(2, "little") + literal
    assert send(client, body, kind=kind).status_code in (400, 413, 422)
