"""Who asks for a grid that is too coarse for a thin zero set is told: over HTTP in a header, else in a line of text."""

from io import BytesIO
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from service.cli.app import app
from tests.service.bodies import Array, npy, sphere
from tests.service.posted import fitted, post

HEADER = "Zero-Set-Warning"


def ellipsoid(*axes: float) -> Array:
    """Return 1,000 points on an ellipse or ellipsoid, turned, with their normals, (1000, 2d)."""
    d, half = len(axes), np.array(axes)
    rng = np.random.default_rng(0)
    u = rng.normal(size=(1000, d))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    R, _ = np.linalg.qr(rng.normal(size=(d, d)))
    normals = u / half
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.hstack([u * half @ R.T, normals @ R.T])


@pytest.fixture(scope="module")
def needle(client: httpx.Client) -> dict[str, Any]:
    return fitted(client, npy(ellipsoid(20.0, 1.0, 1.0)), "max_degree=2&constraints=taubin")


@pytest.fixture(scope="module")
def blade(client: httpx.Client) -> dict[str, Any]:
    return fitted(client, npy(ellipsoid(50.0, 1.0)), "max_degree=2&constraints=taubin")


@pytest.mark.parametrize("resolution", [16, 24, 32])
def test_a_coarse_grid_of_a_needle_is_told_in_a_header(
    client: httpx.Client, needle: dict[str, Any], resolution: int
) -> None:
    answer = client.get(f"/v1/fits/{needle['id']}/mesh?format=ply&resolution={resolution}")
    assert answer.status_code == 200
    assert f"resolution {resolution}" in answer.headers[HEADER]
    assert "Ask for a higher resolution" in answer.headers[HEADER]


@pytest.mark.parametrize("extent", ["data", "bounds"])
def test_the_default_grid_of_a_needle_is_fine_enough(client: httpx.Client, needle: dict[str, Any], extent: str) -> None:
    answer = client.get(f"/v1/fits/{needle['id']}/mesh?format=ply&extent={extent}")
    assert HEADER not in answer.headers
    mesh = trimesh.load_mesh(BytesIO(answer.content), file_type="ply")
    assert mesh.volume == pytest.approx(4.0 / 3.0 * np.pi * 20.0, rel=0.03)


@pytest.mark.parametrize("name", ["svg", "geojson"])
def test_a_coarse_grid_of_a_blade_is_told_in_a_header(client: httpx.Client, blade: dict[str, Any], name: str) -> None:
    where = f"/v1/fits/{blade['id']}/mesh?format={name}"
    assert "thinner than 4 cells" in client.get(f"{where}&resolution=100").headers[HEADER]
    assert HEADER not in client.get(where).headers


def test_a_post_that_answers_with_a_file_and_ordinary_shapes_have_no_warning(client: httpx.Client) -> None:
    answer = post(client, npy(sphere()), Accept="model/ply")
    assert (answer.status_code, HEADER in answer.headers) == (200, False)
    answer = post(client, npy(ellipsoid(50.0, 1.0)), "max_degree=2&constraints=taubin", Accept="image/svg+xml")
    assert (answer.status_code, HEADER in answer.headers) == (200, False)


def test_the_header_is_documented_wherever_a_zero_set_is_sent(client: httpx.Client) -> None:
    paths = client.get("/openapi.json").json()["paths"]
    for operation in (paths["/v1/fits"]["post"], paths["/v1/fits/{fit_id}/mesh"]["get"]):
        assert HEADER in operation["responses"]["200"]["headers"]


@pytest.mark.parametrize(("arguments", "told"), [(["--resolution", "24"], True), ([], False)])
def test_the_command_line_says_so_too(tmp_path: Path, arguments: list[str], *, told: bool) -> None:
    np.save(tmp_path / "needle.npy", ellipsoid(20.0, 1.0, 1.0))
    options = ["--max-degree", "2", "--constraints", "taubin", "--mesh", str(tmp_path / "needle.ply"), *arguments]
    done = CliRunner().invoke(app, ["fit", str(tmp_path / "needle.npy"), *options])
    assert done.exit_code == 0, done.output
    assert ("warning: 100% of the zero set is thinner than 4 cells" in done.output) == told
