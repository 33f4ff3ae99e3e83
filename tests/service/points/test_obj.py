"""OBJ: which normal belongs to which vertex, and vertices in two dimensions."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from service.formats.points import decode
from tests.service.bodies import ellipse
from tests.service.points.geometry import BALL, FACES, QUICK, VERTICES, gives, read, refused, rows

OUTLINE = ellipse(20)


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
    together: bool,
    colours: bool,
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
def test_obj_in_two_dimensions(with_normals: bool) -> None:
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
