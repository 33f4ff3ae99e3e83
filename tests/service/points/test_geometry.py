"""STL and GLB, and what holds of every file of geometry: nothing else is opened, damage and size are refused."""

import struct
import sys
from pathlib import Path

import numpy as np
import orjson
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from service.formats.points import decode
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from tests.service.points.geometry import BALL, FACES, MESH, QUICK, VERTICES, gives, read, refused, rows


def exported(shape: trimesh.Trimesh | trimesh.Scene, kind: str) -> bytes:
    content = shape.export(file_type=kind)
    return content.encode() if isinstance(content, str) else bytes(content)


# STL and GLB


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("form", ["stl", "stl_ascii"])
def test_the_corners_of_stl_triangles_are_points_once(scale: float, form: str) -> None:
    mesh = trimesh.Trimesh(scale * VERTICES, FACES, process=False)
    content = exported(mesh, form)
    x, n = decode.split(read(content, "stl").content, 3)
    assert n is not None
    assert len(x) == len(VERTICES)
    assert np.allclose(np.linalg.norm(x, axis=1), scale, rtol=1e-6)
    assert ((x * n).sum(axis=1) > 0.99 * scale).all()


def test_the_vertices_of_a_glb_stand_where_its_nodes_put_them() -> None:
    scene = trimesh.Scene(MESH)
    scene.add_geometry(MESH, transform=np.eye(4) + 5.0 * np.eye(4, k=3))
    x, n = decode.split(read(exported(scene, "glb"), "glb").content, 3)
    assert n is not None
    assert len(x) == 2 * len(VERTICES)
    assert x[:, 0].max() > 5.9


def test_a_cloud_in_a_glb_is_read() -> None:
    cloud = trimesh.PointCloud(BALL[:, :3])  # type: ignore[no-untyped-call] # trimesh's
    content = exported(trimesh.Scene(cloud), "glb")
    assert gives(read(content, "glb"), BALL[:, :3], within=1e-6)


def changed(change: dict[str, object]) -> bytes:
    """Return a GLB whose JSON has these members instead."""
    content = exported(trimesh.Scene(MESH), "glb")
    size = int.from_bytes(content[12:16], "little")
    tree = orjson.loads(content[20 : 20 + size]) | change
    text = orjson.dumps(tree)
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(content) - 20 - size)
    return head + struct.pack("<I4s", len(text), b"JSON") + text + content[20 + size :]


@pytest.mark.parametrize(
    "change",
    [
        {"accessors": [{"count": 10**9, "componentType": 5126, "type": "VEC3"}]},
        {"accessors": [{"count": -1, "bufferView": 0}]},
        {"accessors": 5},
        {"accessors": [None]},
        {"meshes": [{"primitives": [{"attributes": {"POSITION": 99}}]}]},
        {"meshes": [{}]},
        {"meshes": []},
        {"nodes": [{"mesh": 7}]},
        {"nodes": "x"},
        {"nodes": [{"name": "world", "children": [0]}]},
        {"buffers": [{"byteLength": 9, "uri": "file:///etc/hostname"}]},
        {"buffers": [{"byteLength": 9, "uri": "../secret.bin"}]},
    ],
)
def test_a_glb_that_lies_is_refused(change: dict[str, object]) -> None:
    assert read(changed({}), "glb").points == len(VERTICES)
    refused(changed(change), "glb")


def test_a_mesh_that_is_used_a_million_times_is_too_large() -> None:
    nodes = [{"mesh": 0, "name": str(i)} for i in range(10_000)]
    with pytest.raises(TooLargeError):
        read(changed({"nodes": nodes, "scenes": [{"nodes": list(range(10_000))}]}), "glb", 100_000)


# Files of every format


@pytest.mark.parametrize("kind", ["obj", "off"])
def test_too_many_vertices_are_too_large(kind: str) -> None:
    content = rows("v", VERTICES) if kind == "obj" else f"OFF {len(VERTICES)} 0 0\n" + rows("", VERTICES)
    with pytest.raises(TooLargeError):
        read(content, kind, len(VERTICES) - 1)


@pytest.mark.parametrize("kind", ["ply", "obj", "off", "stl", "glb"])
def test_columns_is_refused_for_files_that_say_themselves_what_they_hold(kind: str) -> None:
    with pytest.raises(InvalidInputError, match="columns is for tables and arrays"):
        decode.read(b"", kind, 1000, columns="x,y,z")


@pytest.mark.parametrize("kind", ["obj", "glb", "ply", "stl", "off"])
def test_no_file_that_another_names_is_opened(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[object] = []
    content = {
        "obj": ("mtllib secret.mtl\nusemtl a\n" + rows("v", BALL[:, :3])).encode(),
        "glb": changed({"images": [{"uri": "secret.png"}], "textures": [{"source": 0}]}),
        "ply": b"ply\nformat ascii 1.0\ncomment TextureFile secret.png\nelement vertex 3\nproperty float x\n"
        b"property float y\nend_header\n0 0\n2 0\n0 1\n",
        "stl": exported(MESH, "stl"),
        "off": ("OFF 30 0 0\n" + rows("", BALL[:, :3])).encode(),
    }[kind]
    monkeypatch.chdir(tmp_path)
    for name in ("secret.mtl", "secret.png"):
        (tmp_path / name).write_text("newmtl a\n")
    watching = [True]  # an audit hook stays for ever
    sys.addaudithook(lambda event, what: opened.append(what[0]) if event == "open" and watching else None)
    try:
        assert read(content, kind).points >= 3
    finally:
        watching.clear()
    assert not [name for name in opened if "secret" in str(name)]


def test_a_file_that_is_larger_than_its_points_can_be_is_not_opened(tmp_path: Path) -> None:
    path = tmp_path / "large.stl"
    with path.open("wb") as file:
        file.truncate(3_000_000)
    with pytest.raises(TooLargeError, match="the file is larger than"):
        decode.read(path, "stl", 1000)


@pytest.mark.parametrize("kind", ["obj", "off", "stl", "glb"])
@QUICK
@given(at=st.integers(0, 3000), damage=st.binary(max_size=6), cut=st.integers(0, 3000))
def test_a_damaged_file_is_read_or_refused(kind: str, at: int, damage: bytes, cut: int) -> None:
    content = WHOLE[kind]
    content = content[:at] + damage + content[at + len(damage) :]
    try:
        read(content if cut > 2000 else content[: len(content) - cut], kind)
    except InvalidInputError as error:
        assert not isinstance(error, MalformedInputError) or str(error)  # noqa: PT017 - nothing else may be raised


WHOLE = {
    "obj": (
        rows("v", VERTICES)
        + rows("vn", VERTICES)
        + "".join(f"f {a + 1}//1 {b + 1}//2 {c + 1}//3\n" for a, b, c in FACES)
    ).encode(),
    "off": (
        f"OFF\n{len(VERTICES)} {len(FACES)} 0\n" + rows("", VERTICES) + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    ).encode(),
    "stl": exported(MESH, "stl"),
    "glb": exported(trimesh.Scene(MESH), "glb"),
}
