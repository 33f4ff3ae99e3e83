"""Fits over HTTP: sent in every format, waited for, dismissed and removed."""

import base64
import json
from pathlib import Path
from typing import Any, Literal
from uuid import uuid4

import httpx
import numpy as np
import pytest

from ipcore import shapes
from tests.service.bodies import HALF_A_MINUTE, LONG, Array, ellipse, npy, sphere, torus
from tests.service.posted import fitted, post, values
from tests.service.running import Server

DOUBLE = float(np.finfo(float).eps)


def packed(table: Array) -> dict[str, Any]:
    return {
        "dtype": table.dtype.str,
        "shape": list(table.shape),
        "data": base64.b64encode(table.tobytes()).decode(),
    }


@pytest.mark.parametrize(("move", "scale"), [(0.0, 1.0), (1000.0, 1.0), (0.0, 37.0), (1000.0, 37.0)])
@pytest.mark.parametrize(("table", "degree"), [(ellipse(), 2), (sphere(), 2), (torus(), 4)])
def test_the_one_sentence_vanishes_on_the_input(
    client: httpx.Client, table: Array, degree: int, move: float, scale: float
) -> None:
    d = 2 if table.shape[1] == 2 else 3
    points = scale * table[:, :d] + move
    fit = fitted(client, npy(np.hstack([points, table[:, d:]])))
    assert fit["polynomial"]["degree"] == degree
    rounding = DOUBLE * (1.0 + abs(move) / scale) * len(fit["polynomial"]["coefficients"])
    at_points = np.abs(values(fit, points))
    assert at_points.max() <= max(fit["diagnostics"]["distance_max"] * 2.0, 100.0 * rounding)
    assert at_points.mean() < 0.01
    centre = points.mean(axis=0)
    inside = centre if degree == 2 else centre + np.array([scale, 0.0, 0.0])  # of a torus: its core circle
    assert values(fit, inside[None])[0] < -0.1
    assert (values(fit, np.array(fit["polynomial"]["bounds"])) > 0.1).all()


@pytest.mark.parametrize("columns", [2, 3, 4, 6])
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["<f8", "<f4", ">f8", ">i4", "<i8", "|i1"])
def test_npy_of_every_number_order_and_width(
    client: httpx.Client, columns: int, order: Literal["C", "F"], kind: str
) -> None:
    source = shapes.circle() if columns in (2, 4) else shapes.sphere()
    points, normals = source.sample(150)
    table = np.round(100.0 * np.hstack([points, normals])[:, :columns])
    fit = fitted(client, npy(table.astype(kind), order=order))
    d = 2 if columns in (2, 4) else 3
    assert (fit["dimension"], fit["points"], fit["polynomial"]["degree"]) == (d, 150, 2)
    given = columns in (4, 6)
    assert (fit["diagnostics"]["normal_source"] == "given") is given
    assert fit["polynomial"]["frame"]["scale"] == pytest.approx(100.0, rel=0.02)


def test_json_and_npy_give_the_same_fit(client: httpx.Client) -> None:
    table = sphere()
    points, normals = table[:, :3], table[:, 3:]
    nested = fitted(client, {"points": points.tolist(), "normals": normals.tolist()})
    binary = fitted(client, {"points": packed(points), "normals": packed(normals)})
    raw = fitted(client, npy(table))
    assert nested["polynomial"] == binary["polynomial"] == raw["polynomial"]
    assert nested["engine"]["input_sha256"] == raw["engine"]["input_sha256"]


@pytest.mark.parametrize("kind", ["<f4", ">f8", "<i2"])
def test_packed_arrays_of_other_numbers(client: httpx.Client, kind: str) -> None:
    fit = fitted(client, {"points": packed(np.round(100.0 * ellipse()).astype(kind))})
    assert fit["polynomial"]["degree"] == 2


def test_options_come_in_the_body_and_in_the_query_which_wins(client: httpx.Client) -> None:
    body = {"points": ellipse().tolist(), "options": {"t1": 0.0, "max_degree": 3, "basis": "chebyshev"}}
    fit = fitted(client, body, "max_degree=4")
    assert (fit["options"]["t1"], fit["options"]["max_degree"]) == (0.0, 4)
    assert (fit["polynomial"]["basis"], len(fit["steps"]), fit["stop_reason"]) == ("chebyshev", 4, "max-degree")


def test_format_in_the_query_wins_over_the_content_type(client: httpx.Client) -> None:
    headers = {"Content-Type": "application/octet-stream"}
    assert client.post("/v1/fits?format=npy", content=npy(ellipse()), headers=headers).status_code == 200
    assert client.post("/v1/fits", content=npy(ellipse()), headers=headers).status_code == 415


def test_a_plane_is_fitted_by_degree_1_with_a_warning(client: httpx.Client) -> None:
    flat = np.random.default_rng(0).uniform(size=(50, 3)) * [1.0, 1.0, 0.0]
    fit = fitted(client, npy(flat))
    assert (fit["polynomial"]["degree"], fit["stop_reason"]) == (1, "planar")
    assert [warning["code"] for warning in fit["warnings"]] == ["planar"]


def test_async_then_long_poll(shared: Server) -> None:
    answer = post(shared.client, LONG, "t1=0&max_degree=6", Prefer="respond-async")
    assert answer.status_code == 202
    assert answer.headers["Preference-Applied"] == "respond-async"
    assert answer.headers["Retry-After"].isdecimal()
    where = answer.headers["Location"]
    assert where == f"/v1/fits/{answer.json()['id']}"
    assert shared.client.get(where).json()["status"] in ("accepted", "running")
    now = shared.client.get(where, headers={"Prefer": "wait=30"})
    assert now.headers["Preference-Applied"] == "wait=30"
    assert now.json()["status"] == "successful"
    assert "progress" not in now.json()
    assert "Retry-After" not in now.headers


def test_an_idempotency_key_gets_one_fit_and_takes_no_other_payload(shared: Server) -> None:
    key = {"Idempotency-Key": f'"{uuid4().hex}"', "Prefer": "respond-async"}
    first = post(shared.client, LONG, "t1=0&max_degree=6", **key)
    running = post(shared.client, LONG, "t1=0&max_degree=6", **key)
    assert (first.status_code, running.status_code) == (202, 202)
    shared.look(first.json(), wait=60)
    ended = post(shared.client, LONG, "t1=0&max_degree=6", **key)
    assert (ended.status_code, ended.json()["status"]) == (200, "successful")
    assert [one.headers.get("Idempotency-Replayed") for one in (first, running, ended)] == [None, "true", "true"]
    assert first.json()["id"] == running.json()["id"] == ended.json()["id"]
    for body, query in ((LONG, "t1=0&max_degree=5"), (npy(ellipse()), "t1=0&max_degree=6")):
        other = post(shared.client, body, query, **key)
        assert (other.status_code, other.json()["type"]) == (422, "/problems/key-reused")


@pytest.mark.parametrize("prefer", ["wait=0", "wait=1, respond-async"])
def test_a_short_wait_ends_with_202(shared: Server, prefer: str) -> None:
    answer = post(shared.client, LONG, HALF_A_MINUTE, Prefer=prefer)
    assert answer.status_code == 202
    assert answer.elapsed.total_seconds() < 5.0
    unfinished = shared.client.get(f"{answer.headers['Location']}/mesh")
    assert unfinished.status_code == 409
    assert unfinished.json()["type"] == "/problems/fit-not-finished"
    assert "Retry-After" in unfinished.headers
    assert shared.client.delete(answer.headers["Location"]).json()["status"] == "dismissed"


def blobs(server: Server) -> set[Path]:
    return {path for path in (server.folder / "blobs").rglob("*") if path.is_file()}


def test_a_removed_fit_takes_its_points_along_unless_others_need_them(shared: Server) -> None:
    before = blobs(shared)
    body = npy(ellipse(77))
    first, second = (fitted(shared.client, body) for _ in range(2))
    (stored,) = blobs(shared) - before  # the same points are stored once
    for fit, kept in ((first, True), (second, False)):
        where = f"/v1/fits/{fit['id']}"
        gone = shared.client.delete(f"{where}?purge=true")
        assert (gone.status_code, gone.content) == (204, b"")
        assert stored.exists() is kept
        assert shared.client.get(where).status_code == 404
        assert shared.client.get(f"{where}/mesh").status_code == 404
        assert shared.client.delete(where).status_code == 404


def test_a_large_body_goes_through_a_worker_and_leaves_nothing(shared: Server) -> None:
    table = torus(20_000)
    body = json.dumps({"points": table[:, :3].tolist(), "options": {"max_degree": 2}}).encode()
    assert len(body) > 2**20
    headers = {"Content-Type": "application/json"}
    sent = shared.client.post("/v1/fits", content=body, headers=headers | {"Prefer": "respond-async"})
    assert sent.json()["points"] == 20_000
    broken = shared.client.post("/v1/fits", content=body[:-9], headers=headers)
    assert (broken.status_code, broken.json()["type"]) == (400, "/problems/malformed-input")
    wrong = shared.client.post("/v1/fits", content=body.replace(b"]]", b"],[1]]"), headers=headers)
    assert (wrong.status_code, wrong.json()["errors"][0]["pointer"]) == (422, "/points/20000")
    assert not list((shared.folder / "incoming").iterdir())
