"""Requests that public reports of other services describe: each is answered with 4xx and says why."""

import base64
import json
import struct
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from ipcore import shapes
from tests.service.bodies import npy, sphere
from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.running import Server

WRONG_IDS = ["%00", "a%00b", "nobody", "0" * 31, "0" * 33, "0" * 32, "G" * 32, "%F0%9F%90%8E", "..%2f..", "%25", "'--"]


@pytest.fixture(scope="module")
def cluster_server(tmp_path_factory: pytest.TempPathFactory, postgres: Postgres) -> Iterator[Server]:
    cluster = Cluster(tmp_path_factory.mktemp("cluster"), postgres)
    yield cluster.serve()
    cluster.end()


@pytest.mark.parametrize("wrong", WRONG_IDS)
@pytest.mark.parametrize("engine", ["shared", "cluster_server"])
def test_what_no_fit_is_called_is_not_found(request: pytest.FixtureRequest, engine: str, wrong: str) -> None:
    server: Server = request.getfixturevalue(engine)
    for method, path in (("GET", ""), ("DELETE", ""), ("GET", "/mesh"), ("HEAD", "")):
        answer = server.client.request(method, f"/v1/fits/{wrong}{path}")
        assert answer.status_code == 404, (method, path, answer.text)


@pytest.mark.parametrize("depth", [2, 3, 100, 257, 500, 1000, 1023, 1024, 1025, 5000, 100_000])
@pytest.mark.parametrize("member", ["points", "normals", "options"])
def test_deeply_nested_json_is_refused(client: httpx.Client, member: str, depth: int) -> None:
    nested = "[" * depth + "]" * depth
    members = {"points": "[[0,0],[1,0],[0,1],[1,1]]", member: nested}
    body = "{" + ",".join(f'"{name}":{value}' for name, value in members.items()) + "}"
    answer = client.post("/v1/fits", content=body, headers={"Content-Type": "application/json"})
    assert answer.status_code in {400, 422}, answer.text
    assert len(answer.content) < 2000


SHAPES: list[list[Any]] = [
    [0, 2**63], [0, 2**62], [2**63, 0], [2**62, 2], [2**32, 2**32], [-1, 2], [2, -1], [-1, -1], [0, 2], [4, 0], [0, 0],
    [True, 2], [4, True], [4.0, 2], ["4", 2], [None, 2], [4], [4, 2, 1], [], [[4], [2]], [2**64, 2], [10**30, 2],
]  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_impossible_shapes_of_packed_arrays_are_refused(client: httpx.Client, shape: list[Any]) -> None:
    data = base64.b64encode(bytes(64)).decode()
    body = json.dumps({"points": {"dtype": "<f8", "shape": shape, "data": data}})
    answer = client.post("/v1/fits", content=body, headers={"Content-Type": "application/json"})
    assert answer.status_code in {400, 413, 422}, answer.text


@pytest.mark.parametrize(
    "shape", ["(0, 9223372036854775808)", "(0, 4611686018427387904)", "(True, 2)", "(-4, 2)", "(4, -2)", "(4,)", "()",
              "(4, 2, 1)", "(0, 2)", "(2**62, 2)", "(4.0, 2)", "('4', 2)", "(10000000000000000000, 2)", "4, 2", "None"]
)  # fmt: skip
def test_impossible_shapes_of_npy_files_are_refused(client: httpx.Client, shape: str) -> None:
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    body = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + bytes(64)
    answer = client.post("/v1/fits", content=body, headers={"Content-Type": "application/x-npy"})
    assert answer.status_code in {400, 413, 422}, answer.text


@pytest.fixture(scope="module")
def fits(shared: Server) -> dict[int, str]:
    """Return the ids of a fit in 2D and one in 3D."""
    circle, _ = shapes.circle().sample(60)
    return {2: shared.fit(npy(circle))["id"], 3: shared.fit(npy(sphere()))["id"]}


@pytest.mark.parametrize("bounds", ["1e308", "1e200", "1.7e308", "inf", "nan", "1e999", "0", "-1"])
@pytest.mark.parametrize(
    ("dimension", "kind"), [(2, "svg"), (2, "geojson"), (3, "ply"), (3, "glb"), (3, "stl"), (3, "obj")]
)
def test_bounds_that_cannot_be_computed_with_are_refused(
    client: httpx.Client, fits: dict[int, str], dimension: int, kind: str, bounds: str
) -> None:
    text = ",".join([f"-{bounds}"] * dimension + [bounds] * dimension)
    answer = client.get(f"/v1/fits/{fits[dimension]}/mesh", params={"bounds": text, "format": kind})
    assert answer.status_code == 422, answer.text
    assert answer.json()["errors"][0]["parameter"] == "bounds"


@pytest.mark.parametrize("bounds", ["1e-300", "1e-12", "1e9", "1e40"])
def test_extreme_bounds_give_an_answer_or_are_refused(client: httpx.Client, fits: dict[int, str], bounds: str) -> None:
    for dimension in (2, 3):
        text = ",".join([f"-{bounds}"] * dimension + [bounds] * dimension)
        answer = client.get(f"/v1/fits/{fits[dimension]}/mesh", params={"bounds": text, "resolution": 16})
        assert answer.status_code in {200, 422}, answer.text


@pytest.mark.parametrize(
    ("scale", "shift", "refused"),
    [
        (1.0, 0.0, ""), (1e-12, 0.0, ""), (1e30, 0.0, ""), (1e60, 0.0, "stl glb"), (1e-60, 0.0, "stl glb"),
        (1.0, 1e9, "stl"), (1.0, 1e40, "stl glb"), (1e36, 1e38, ""),
    ],
)  # fmt: skip
def test_single_precision_files_are_right_or_refused(shared: Server, scale: float, shift: float, refused: str) -> None:
    points = sphere()
    points[:, :3] = scale * points[:, :3] + shift
    if shift == 1e40:  # where the sphere is a single place, to rounding
        points[:, :3] = 1e30 * sphere()[:, :3] + shift
    fit = shared.fit(npy(points))
    assert fit["status"] == "successful", fit
    for kind in ("stl", "glb", "ply", "obj"):
        answer = shared.client.get(f"/v1/fits/{fit['id']}/mesh", params={"format": kind, "resolution": 16})
        assert answer.status_code == (422 if kind in refused.split() else 200), (kind, answer.text[:300])
        if answer.status_code == 422:
            assert "ply or obj" in answer.json()["detail"]


def test_a_server_that_answered_all_of_this_is_well(client: httpx.Client) -> None:
    assert client.get("/readyz").status_code == 200
