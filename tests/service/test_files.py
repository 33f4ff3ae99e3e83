"""Point sets from files, by their ending."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from service.formats.points import by_ending, decode
from service.jobs.errors import InvalidInputError, MalformedInputError
from tests.service.bodies import ellipse, sphere


def saved(folder: Path, ending: str) -> Path:
    """Write points of a sphere with their normals, and return the file."""
    table, path = sphere(50), folder / f"sphere{ending}"
    if ending == ".npy":
        np.save(path, table)
    elif ending == ".npz":
        np.savez(path, points=table[:, :3], normals=table[:, 3:])
    elif ending == ".json":
        path.write_text(json.dumps({"points": table[:, :3].tolist(), "normals": table[:, 3:].tolist()}))
    elif ending == ".csv":
        np.savetxt(path, table, delimiter=",", header="x,y,z,nx,ny,nz", comments="")
    else:
        np.savetxt(path, table, header="a comment")
    return path


@pytest.mark.parametrize("ending", [".npy", ".npz", ".json", ".csv", ".txt", ".xyz", ".asc"])
def test_tables_give_points_and_normals(tmp_path: Path, ending: str) -> None:
    found = by_ending.read_file(saved(tmp_path, ending), 1000)
    points, normals = decode.split(found.content, 3)
    assert normals is not None
    assert np.allclose(points, sphere(50)[:, :3], atol=1e-15)
    assert np.allclose(normals, sphere(50)[:, 3:], atol=1e-15)


@pytest.mark.parametrize("ending", [".ply", ".obj", ".off", ".stl", ".glb"])
def test_meshes_give_their_vertices_and_outward_normals(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"ball{ending}"
    trimesh.creation.icosphere(subdivisions=2).export(path)
    found = by_ending.read_file(path, 10_000)
    points, normals = decode.split(found.content, 3)
    assert normals is not None
    assert np.allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-6)
    assert (np.einsum("ij,ij->i", points, normals) > 0.9).all()


def test_a_cloud_without_normals_gives_points_alone(tmp_path: Path) -> None:
    path = tmp_path / "cloud.ply"
    cloud = trimesh.PointCloud(sphere(50)[:, :3])  # type: ignore[no-untyped-call] # trimesh's
    cloud.export(path)  # type: ignore[no-untyped-call] # trimesh leaves it unannotated
    found = by_ending.read_file(path, 1000)
    assert found.points == 50
    assert decode.split(found.content, 3)[1] is None


def test_endings_are_read_in_any_case(tmp_path: Path) -> None:
    path = tmp_path / "OUTLINE.CSV"
    np.savetxt(path, ellipse(), delimiter=";")
    assert by_ending.read_file(path, 1000).dimension == 2


@pytest.mark.parametrize("ending", by_ending.ENDINGS)
@pytest.mark.parametrize(
    "content", [b"", b"\x00\xff\x93 no such thing", b"one,two\nthree,four\n", b"solid\nply\nOFF\n1"]
)
def test_a_file_that_is_something_else_is_refused(tmp_path: Path, ending: str, content: bytes) -> None:
    path = tmp_path / f"wrong{ending}"
    path.write_bytes(content)
    with pytest.raises(InvalidInputError):
        by_ending.read_file(path, 1000)


def test_an_unknown_ending_is_named(tmp_path: Path) -> None:
    path = tmp_path / "points.docx"
    path.write_bytes(b"")
    with pytest.raises(MalformedInputError, match=r"points\.docx does not end in one of"):
        by_ending.read_file(path, 1000)


def test_an_npz_of_several_arrays_of_which_none_is_called_points_says_so(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, vertices=sphere(50), colours=sphere(50))
    with pytest.raises(InvalidInputError, match="must be called points; here are colours, vertices"):
        by_ending.read_file(path, 1000)
