"""`ipfit fit` on real files."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner, Result

import ipcore
from ipcore import shapes
from service.cli.app import app


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["fit", *map(str, arguments)])


@pytest.fixture
def torus(tmp_path: Path) -> Path:
    points, normals = shapes.torus().sample(1500)
    np.savez(tmp_path / "torus.npz", points=points, normals=normals)
    return tmp_path / "torus.npz"


@pytest.fixture
def ellipse(tmp_path: Path) -> Path:
    angle = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    np.savetxt(tmp_path / "ellipse.csv", np.column_stack([3 * np.cos(angle), 2 * np.sin(angle)]), delimiter=",")
    return tmp_path / "ellipse.csv"


def test_a_surface_its_mesh_its_picture_and_its_json(torus: Path, tmp_path: Path) -> None:
    mesh, plot, output = tmp_path / "t.ply", tmp_path / "t.svg", tmp_path / "t.json"
    done = run(torus, "--mesh", mesh, "--resolution", 48, "--plot", plot, "--output", output)
    assert done.exit_code == 0, done.output
    assert "degree 4, 35 coefficients, stopped: criterion-met" in done.output
    assert "D_dist 0.0000" in done.stderr  # the bar shows each degree as it comes
    assert trimesh.load_mesh(mesh).euler_number == 0
    assert plot.read_bytes().startswith(b"<svg")
    result = json.loads(output.read_bytes())
    polynomial = ipcore.ImplicitPolynomial.from_dict(result["polynomial"])
    points = np.load(torus)["points"]
    assert np.abs(polynomial.distance(points)).mean() < 0.01


@pytest.mark.parametrize("ending", ["svg", "geojson"])
def test_an_outline_and_its_curve(ellipse: Path, tmp_path: Path, ending: str) -> None:
    target = tmp_path / f"curve.{ending}"
    done = run(ellipse, "--mesh", target, "--max-degree", 4)
    assert done.exit_code == 0, done.output
    assert "120 points in 2D, normals outline" in done.output
    assert target.stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--mesh", "curve.glb"], "must end in one of svg, geojson"),
        (["--max-degree", "41"], "41"),
        (["--t1", "-1"], "-1"),
    ],
)
def test_wrong_options_are_refused_before_the_work(ellipse: Path, arguments: list[str], says: str) -> None:
    done = run(ellipse, *arguments)
    assert done.exit_code == 2
    assert says in done.stderr
    assert not done.stdout


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("line.csv", "0,0\n1,1\n2,2\n3,3\n", "on one line"),
        ("short.csv", "0,0\n1,1\n", "too few"),
        ("words.csv", "x,y\n1,two\n", "line 2, column 2 (y) is not a number: 'two'"),
        ("ragged.csv", "1,2\n1,2,3\n", "line 2 has 3 cells, but line 1 has 2"),
        ("points.docx", "", "does not end in one of"),
        ("broken.npy", "no array", "not an npy file"),
        ("broken.npz", "no archive", "not an npz file"),
    ],
)
def test_files_that_cannot_be_fitted(tmp_path: Path, name: str, content: str, says: str) -> None:
    (tmp_path / name).write_text(content)
    done = run(tmp_path / name)
    assert done.exit_code == 2
    assert says in done.stderr


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    assert run(tmp_path / "nothing.npy").exit_code == 2
