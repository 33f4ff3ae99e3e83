"""What a finished fit gives over HTTP: itself, unless it is known, and its zero set in every format."""

import re
from io import BytesIO
from typing import Any

import httpx
import numpy as np
import pytest
import trimesh

from tests.service.bodies import Array, ellipse, npy, sphere, torus
from tests.service.posted import fitted, post, values

SINGLE = float(np.finfo(np.float32).eps)


@pytest.fixture(scope="module")
def surface(client: httpx.Client) -> dict[str, Any]:
    return fitted(client, npy(sphere()))


@pytest.fixture(scope="module")
def curve(client: httpx.Client) -> dict[str, Any]:
    return fitted(client, npy(ellipse()))


def test_an_unchanged_fit_is_not_sent_again(client: httpx.Client, curve: dict[str, Any]) -> None:
    where = f"/v1/fits/{curve['id']}"
    first = client.get(where)
    etag = first.headers["ETag"]
    assert re.fullmatch(r'"[0-9a-f]+"', etag)
    for sent in (etag, f'"other", {etag}', f"W/{etag}", "*"):
        again = client.get(where, headers={"If-None-Match": sent})
        assert (again.status_code, again.content, again.headers["ETag"]) == (304, b"", etag), sent
    assert client.get(where, headers={"If-None-Match": '"other"'}).status_code == 200


@pytest.mark.parametrize(("name", "media"), [("glb", "model/gltf-binary"), ("ply", "model/ply"), ("stl", "model/stl")])
def test_post_answers_with_the_mesh_itself(client: httpx.Client, name: str, media: str) -> None:
    answer = post(client, npy(torus()), Accept=media)
    assert (answer.status_code, answer.headers["Content-Type"]) == (200, media)
    mesh = trimesh.load_mesh(BytesIO(answer.content), file_type=name)
    mesh.merge_vertices()
    assert mesh.is_watertight
    assert mesh.euler_number == 0
    assert mesh.volume == pytest.approx(2.0 * np.pi**2 * 0.4**2, rel=0.02)
    assert client.get(answer.headers["Location"]).json()["status"] == "successful"


@pytest.mark.parametrize(("name", "media"), [("glb", "model/gltf-binary"), ("obj", "model/obj"), ("ply", "model/ply")])
@pytest.mark.parametrize("by", ["format", "accept"])
def test_a_surface_in_every_format(
    client: httpx.Client, surface: dict[str, Any], name: str, media: str, by: str
) -> None:
    query, headers = (f"?format={name}", {}) if by == "format" else ("", {"Accept": f"image/png, {media};q=0.5"})
    answer = client.get(f"/v1/fits/{surface['id']}/mesh{query}", headers=headers)
    assert (answer.status_code, answer.headers["Content-Type"].partition(";")[0]) == (200, media)
    assert f'{surface["id"]}.{name}"' in answer.headers["Content-Disposition"]
    mesh = trimesh.load_mesh(BytesIO(answer.content), file_type=name)
    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 1.0).max() < 0.01


def test_a_curve_in_every_format(client: httpx.Client, curve: dict[str, Any]) -> None:
    where = f"/v1/fits/{curve['id']}/mesh"
    assert client.get(where).headers["Content-Type"] == "image/svg+xml"
    document = client.get(where, headers={"Accept": "application/geo+json"}).json()
    points = np.concatenate(document["geometry"]["coordinates"])
    assert np.abs(values(curve, points)).max() < 1e-6


def test_resolution_bounds_and_extent(client: httpx.Client, surface: dict[str, Any]) -> None:
    where = f"/v1/fits/{surface['id']}/mesh?format=ply"

    def vertices(query: str) -> Array:
        answer = client.get(f"{where}&{query}")
        assert answer.status_code == 200, answer.text
        found: Array = np.asarray(trimesh.load_mesh(BytesIO(answer.content), file_type="ply").vertices)
        return found

    coarse, fine = vertices("resolution=16"), vertices("resolution=48")
    assert 4 * len(coarse) < len(fine)
    half = vertices("bounds=-2,-2,0,2,2,2&extent=bounds")
    assert half[:, 2].min() > -10.0 * SINGLE
    assert half[:, 2].max() > 0.9


def test_what_cannot_be_had_is_refused(client: httpx.Client, surface: dict[str, Any], curve: dict[str, Any]) -> None:
    for fit, asked in ((surface, "svg"), (curve, "glb")):
        answer = client.get(f"/v1/fits/{fit['id']}/mesh?format={asked}")
        assert answer.status_code == 406, asked
        assert answer.json()["type"] == "/problems/not-acceptable"
    assert client.get(f"/v1/fits/{curve['id']}/mesh", headers={"Accept": "model/stl"}).status_code == 406
    before = post(client, npy(ellipse()), Accept="model/stl")
    assert before.status_code == 406
    assert "Location" not in before.headers  # refused before it was accepted
