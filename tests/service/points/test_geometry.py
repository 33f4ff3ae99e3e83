"""OBJ, OFF, STL and GLB: points, normals and dimension as the file has them, and nothing else opened."""

import struct
import sys
from pathlib import Path

import numpy as np
import orjson
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from service.formats.points import decode
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from service.jobs.fit import PointSet
from tests.service.bodies import Array, ellipse, sphere

BALL = sphere(30)
OUTLINE = ellipse(20)
MESH = trimesh.creation.icosphere(subdivisions=1)
VERTICES, FACES = np.asarray(MESH.vertices), np.asarray(MESH.faces)
QUICK = settings(deadline=None, max_examples=40)


def read(content: bytes | str, kind: str, most: int = 1000) -> PointSet:
    return decode.read(content.encode() if isinstance(content, str) else content, kind, most)


def refused(content: bytes | str, kind: str) -> str:
    with pytest.raises(InvalidInputError) as caught:
        read(content, kind)
    return str(caught.value)


def gives(found: PointSet, points: Array, normals: Array | None = None, within: float = 1e-9) -> bool:
    x, n = decode.split(found.content, found.dimension)
    if (n is None) != (normals is None) or x.shape != points.shape:
        return False
    return np.allclose(x, points, atol=within) and (
        n is None or normals is None or np.allclose(n, normals, atol=within)
    )


def exported(shape: trimesh.Trimesh | trimesh.Scene, kind: str) -> bytes:
    content = shape.export(file_type=kind)
    return content.encode() if isinstance(content, str) else bytes(content)


def rows(word: str, table: Array, end: str = "\n") -> str:
    return "".join(" ".join([word, *map(repr, map(float, row))]).strip() + end for row in table)


# OBJ


@QUICK
@given(
    together=st.booleans(),
    colours=st.booleans(),
    end=st.sampled_from(["\n", "\r\n", " \n"]),
    more=st.lists(
        st.sampled_from(["# c", "mtllib ../a.mtl", "usemtl a", "o ball", "g a b", "s off", "vt 0 0", "p 1", ""])
    ),
    mark=st.sampled_from(["", "﻿"]),
)
def test_the_normals_of_a_cloud_in_obj(
    together: bool,  # noqa: FBT001
    colours: bool,  # noqa: FBT001
    end: str,
    more: list[str],
    mark: str,
) -> None:
    vertices = np.hstack([BALL[:, :3], np.full((30, 3), 0.5)]) if colours else BALL[:, :3]
    v, vn = rows("v", vertices, end).splitlines(keepends=True), rows("vn", BALL[:, 3:], end).splitlines(keepends=True)
    lines = [line for pair in zip(v, vn, strict=True) for line in pair] if together else [*v, *vn]
    content = mark + "".join(lines[:9]) + "".join(line + end for line in more) + "".join(lines[9:])
    assert gives(read(content, "obj"), BALL[:, :3], BALL[:, 3:])


@pytest.mark.parametrize("corner", ["{0}", "{0}/1", "{0}/", "{0}//", "-{1}", "-{1}/1"])
def test_faces_of_obj_give_normals_and_drop_no_vertex(corner: str) -> None:
    def faces(count: int) -> str:
        return "".join("f " + " ".join(corner.format(i + 1, count - i) for i in face) + "\n" for face in FACES)

    content = "vt 0 0\n" + rows("v", VERTICES) + faces(len(VERTICES))
    assert gives(read(content, "obj"), VERTICES, VERTICES, 0.05)
    more = np.vstack([VERTICES, [[5.0, 5.0, 5.0]]])
    assert gives(read("vt 0 0\n" + rows("v", more) + faces(len(more)), "obj"), more)


@pytest.mark.parametrize("corner", ["{0}//{1}", "{0}/1/{1}", "-{2}//-{3}"])
def test_faces_of_obj_say_which_normal_belongs_to_which_vertex(corner: str) -> None:
    n, reverse = len(VERTICES), VERTICES[::-1]
    faces = "".join("f " + " ".join(corner.format(i + 1, n - i, n - i, i + 1) for i in f) + "\n" for f in FACES)
    content = "vt 0 0\n" + rows("v", 2.0 * VERTICES) + rows("vn", 3.0 * reverse) + faces
    assert gives(read(content, "obj"), 2.0 * VERTICES, VERTICES)


def test_a_vertex_with_several_normals_has_their_mean_and_stays_one() -> None:
    box = trimesh.creation.box()
    content = rows("v", np.asarray(box.vertices)) + rows("vn", np.asarray(box.face_normals))
    content += "".join(f"f {a + 1}//{i} {b + 1}//{i} {c + 1}//{i}\n" for i, (a, b, c) in enumerate(box.faces, 1))
    x, n = decode.split(read(content, "obj").content, 3)
    assert n is not None
    assert len(x) == 8
    assert ((x * n).sum(axis=1) > 0.7).all()


@pytest.mark.parametrize("with_normals", [False, True])
def test_obj_in_two_dimensions(with_normals: bool) -> None:  # noqa: FBT001 - of the table
    normals = np.eye(2)[[0, 1] * 10]
    content = rows("v", OUTLINE) + (rows("vn", normals) if with_normals else "") + "l 1 2 3\nf 1 2 3\n"
    assert gives(read(content, "obj"), OUTLINE, normals if with_normals else None)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "no vertices"),
        ("vn 1 0 0\nf 1 2 3\n", "no vertices"),
        ("v 1 2 three\n", "line 1"),
        ("v 1 2 3\n\nv 1\n", "line 3: 1 numbers"),
        ("v 1 2 3\nv 1 2\n", "line 2: 2 numbers"),
        ("v 1 2 3\nf 1 a 3\n", "line 2"),
        ("v 1 2 3\nf\nf 1 2 9\n", "a face has vertex"),
        (rows("v", BALL[:, :3]) + "f 1 2 31\n", "a face has vertex 30"),
        (rows("v", BALL[:, :3]) + "f 0 1 2\n", "line 31"),
        (rows("v", BALL[:, :3]) + "vn 1 0 0\nf 1//2 2//2 3//2\n", "not there"),
        (rows("v", BALL[:, :3]) + "vn 1 0 0\nf 1//1 2//1 31//1\n", "not there"),
        (rows("v", BALL[:, :3]) + "vn 1 0 0\n", "30 vertices and 1 normals"),
    ],
)
def test_obj_that_does_not_make_points_is_refused(content: str, says: str) -> None:
    assert says in refused(content, "obj")


# OFF


@QUICK
@given(
    prefix=st.sampled_from(["", "C", "N", "CN", "ST", "STCN", "N"]),
    same_line=st.booleans(),
    edges=st.sampled_from(["", " 0", " 99"]),
    comments=st.booleans(),
    end=st.sampled_from(["\n", "\r\n", "\n\n"]),
    faces=st.booleans(),
)
def test_off_with_and_without_faces_normals_and_colours(  # noqa: PLR0913, PLR0917 - drawn
    prefix: str,
    same_line: bool,  # noqa: FBT001
    edges: str,
    comments: bool,  # noqa: FBT001
    end: str,
    faces: bool,  # noqa: FBT001
) -> None:
    normals = VERTICES[::-1]
    table = np.hstack([VERTICES, normals]) if "N" in prefix else VERTICES
    more = " 255 0 0 255" if "C" in prefix.upper() else ""
    more += " 0.5 0.5" if prefix.startswith("ST") else ""
    count = f"{len(VERTICES)} {len(FACES) if faces else 0}{edges}"
    content = f"{prefix}OFF" + (" " if same_line else end) + count + end
    content += ("# a comment" + end) * comments
    content += "".join(line + more + end for line in rows("", table).splitlines())
    content += "".join(f"3 {a} {b} {c} 0.1 0.2 0.3{end}" for a, b, c in FACES) if faces else ""
    given_ = normals if "N" in prefix else None
    if faces and given_ is None:
        assert gives(read(content, "off"), VERTICES, VERTICES, 0.05)
    else:
        assert gives(read(content, "off"), VERTICES, given_)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "does not begin with OFF"),
        ("OFFICE\n1 0 0\n0 0 0\n", "does not begin with OFF"),
        ("4OFF\n1 0 0\n0 0 0 0\n", "three dimensions"),
        ("nOFF\n2\n1 0 0\n0 0\n", "three dimensions"),
        ("OFF BINARY\n\0\0\0", "binary"),
        ("OFF\n", "not an OFF file"),
        ("OFF\nthree\n", "not an OFF file"),
        ("OFF\n-1 0 0\n", "do not fit"),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n", "there are 2"),
        ("OFF\n999 0 0\n0 0 0\n1 0 0\n", "do not fit"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a face has vertex 3"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "face 0 has 2"),
        ("OFF\n3 0 0\n0 0 0\n1 0\n0 1 0\n", "vertex 1 has 2 numbers"),
        ("OFF\n3 0 0\n0 0 0\n1 0 x\n0 1 0\n", "not an OFF file"),
    ],
)
def test_off_that_does_not_make_points_is_refused(content: str, says: str) -> None:
    assert says in refused(content, "off")


@pytest.mark.parametrize("kind", ["obj", "off"])
def test_too_many_vertices_are_too_large(kind: str) -> None:
    content = rows("v", VERTICES) if kind == "obj" else f"OFF {len(VERTICES)} 0 0\n" + rows("", VERTICES)
    with pytest.raises(TooLargeError):
        read(content, kind, len(VERTICES) - 1)


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
