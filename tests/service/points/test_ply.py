"""PLY: any properties of any type in any order, in text and in both byte orders, and headers that lie."""

import struct
import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.formats.points import decode
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from service.jobs.fit import ReceivedPoints
from tests.service.bodies import Array, ellipse, sphere

BALL = sphere(30)
OUTLINE = ellipse(20)
NAMES = ("x", "y", "z", "nx", "ny", "nz")
FORMATS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
INTEGERS = {"char": "i1", "uchar": "u1", "short": "i2", "uint16": "u2", "int": "i4", "uint32": "u4", "int8": "i1"}
FLOATS = {"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"}
TYPES = INTEGERS | FLOATS
QUICK = settings(deadline=None, max_examples=80)
TRIANGLES = [[0, 1, 2], [2, 1, 3]]
POLYGONS = [[0, 1, 2], [0, 1, 2, 3], [4, 5, 6, 7, 8]]


def ply(  # noqa: PLR0913 - what a header can say
    properties: list[tuple[str, str]],
    columns: dict[str, Array],
    form: str = "ascii",
    faces: list[list[int]] | None = None,
    *,
    faces_first: bool = False,
    listed: str | None = None,
    end: str = "\n",
) -> bytes:
    """Write vertices of these (type, name) and faces; `listed` is a list property in front of a vertex's others."""
    order = FORMATS[form]
    count = len(next(iter(columns.values())))
    vertex = [f"element vertex {count}"] + ([f"property list uchar short {listed}"] if listed else [])
    vertex += [f"property {kind} {name}" for kind, name in properties]
    face = [] if faces is None else [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    header = ["ply", f"format {form} 1.0", "comment made here", "obj_info x"]
    header += [*face, *vertex] if faces_first else [*vertex, *face]
    rows, polygons = bytearray(), bytearray()
    for i in range(count):
        values = [np.dtype(order + TYPES[kind]).type(columns[name][i]) for kind, name in properties]
        lists = [i % 4] + [7] * (i % 4) if listed else []
        if form == "ascii":
            rows += (" ".join([*map(str, lists), *(repr(value.item()) for value in values)]) + end).encode()
        else:
            rows += struct.pack(f"{order}B{i % 4}h", *lists) if listed else b""
            rows += b"".join(
                np.array(v, dtype=order + TYPES[k]).tobytes() for v, (k, _) in zip(values, properties, strict=True)
            )
    for polygon in faces or []:
        if form == "ascii":
            polygons += (" ".join(map(str, [len(polygon), *polygon])) + end).encode()
        else:
            polygons += struct.pack(f"{order}B{len(polygon)}i", len(polygon), *polygon)
    body = polygons + rows if faces_first else rows + polygons
    return end.join([*header, "end_header", ""]).encode() + bytes(body)


def named(table: Array, names: tuple[str, ...] = NAMES) -> dict[str, Array]:
    return {name: table[:, i] for i, name in enumerate(names[: table.shape[1]])}


def read(content: bytes, most: int = 1000, **options: Any) -> ReceivedPoints:  # noqa: ANN401 - of decode.read
    return decode.read(content, "ply", most, **options)


def refused(content: bytes) -> str:
    with pytest.raises(InvalidInputError) as caught:
        read(content)
    return str(caught.value)


def gives(found: ReceivedPoints, points: Array, normals: Array | None = None) -> bool:
    x, n = decode.split(found.content, found.dimension)
    if (n is None) != (normals is None):
        return False
    return np.allclose(x, points, atol=1e-6) and (n is None or normals is None or np.allclose(n, normals, atol=1e-6))


@QUICK
@given(
    data=st.data(),
    dimension=st.sampled_from([2, 3]),
    with_normals=st.booleans(),
    form=st.sampled_from(sorted(FORMATS)),
    more=st.lists(
        st.tuples(st.sampled_from(sorted(TYPES)), st.sampled_from(["red", "alpha", "scalar_c", "q", "f_dc_0"]))
    ),
    faces=st.sampled_from([None, [], TRIANGLES, POLYGONS]),
    faces_first=st.booleans(),
    listed=st.sampled_from([None, None, "material"]),
    end=st.sampled_from(["\n", "\n", "\r\n"]),
)
def test_a_cloud_comes_back_whatever_its_properties(  # noqa: PLR0913, PLR0917 - drawn
    data: st.DataObject,
    dimension: int,
    with_normals: bool,
    form: str,
    more: list[tuple[str, str]],
    faces: list[list[int]] | None,
    faces_first: bool,
    listed: str | None,
    end: str,
) -> None:
    points, normals = (OUTLINE, -np.eye(2)[[0, 1] * 10]) if dimension == 2 else (BALL[:, :3], BALL[:, 3:])
    names = [*NAMES[:dimension], *(NAMES[3 : 3 + dimension] if with_normals else ())]
    table = dict(zip(names, np.hstack([points, normals]).T, strict=False))
    own = [(data.draw(st.sampled_from(sorted(FLOATS))), name) for name in names]
    others = list({name: (kind, name) for kind, name in more}.values())
    table |= {name: np.arange(len(points)) % 100 for _, name in others}
    properties = data.draw(st.permutations([*own, *others]))
    content = ply(properties, table, form, faces, faces_first=faces_first, listed=listed, end=end)
    found = read(content)
    if with_normals:
        assert gives(found, points, normals)
    else:
        assert gives(found, points)  # of the few faces, not every vertex has a normal


@pytest.mark.parametrize("kind", sorted(INTEGERS))
@pytest.mark.parametrize("form", sorted(FORMATS))
def test_coordinates_of_any_type(kind: str, form: str) -> None:
    table = np.round(20.0 * BALL[:, :3] + 30.0)
    assert gives(read(ply([(kind, name) for name in "xyz"], named(table), form)), table)


@pytest.mark.parametrize(
    "names", [("X", "Y", "Z", "NX", "NY", "NZ"), ("x", "y", "z", "normal_x", "normal_y", "normal_z")]
)
def test_other_names_of_normals(names: tuple[str, ...]) -> None:
    assert gives(read(ply([("float", name) for name in names], named(BALL, names))), BALL[:, :3], BALL[:, 3:])


@pytest.mark.parametrize("form", sorted(FORMATS))
@pytest.mark.parametrize("faces", ["triangles", "with a quadrangle"])
def test_normals_follow_from_the_faces_of_a_closed_mesh(form: str, faces: str) -> None:
    corners = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    sides = [
        [a, b, c] if s > 0 else [a, c, b]
        for a, x in ((0, 1), (1, -1))
        for b, y in ((2, 1), (3, -1))
        for c, z in ((4, 1), (5, -1))
        if (s := x * y * z)
    ]
    if faces != "triangles":
        sides.append([0, 1, 0, 1])  # of no area
    found = read(ply([("double", name) for name in "xyz"], named(corners), form, sides))
    assert gives(found, corners, corners)


@pytest.mark.parametrize("form", sorted(FORMATS))
def test_vertices_that_no_face_uses_stay(form: str) -> None:
    assert gives(read(ply([("double", name) for name in "xyz"], named(BALL[:, :3]), form, TRIANGLES)), BALL[:, :3])


@pytest.mark.parametrize("form", sorted(FORMATS))
def test_normals_that_are_all_zero_count_as_none(form: str) -> None:
    table = BALL * [1, 1, 1, 0, 0, 0]
    assert gives(read(ply([("float", name) for name in NAMES], named(table), form)), BALL[:, :3])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("form", sorted(FORMATS))
def test_vertices_with_missing_values_are_refused_or_left_out(bad: float, form: str) -> None:
    table = BALL.copy()
    table[7, 1] = bad
    table[8, 3:] = 0.0
    content = ply([("float", name) for name in NAMES], named(table), form)
    assert "missing=drop" in refused(content)
    found = read(content, missing="drop")
    kept = np.delete(BALL, [7, 8], axis=0)
    assert found.left_out == 2
    assert gives(found, kept[:, :3], kept[:, 3:])


GOOD = ply([("float", name) for name in "xyz"], named(BALL[:, :3]), "binary_little_endian", TRIANGLES)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (b"ply\n", b"plz\n", "first line"),
        (b"format binary_little_endian 1.0\n", b"", "no place"),
        (b"format binary_little_endian", b"format binary_middle_endian", "no place"),
        (b"element vertex 30", b"element vertex 33", "do not fit"),
        (b"element vertex 30", b"element vertex -3", "no place"),
        (b"element vertex 30", b"element vertex 999", "do not fit"),
        (b"element vertex 30", b"element vertices 30", "no vertices"),
        (b"element vertex 30", b"element vertex 0", "data end"),
        (b"float x", b"float128 x", "not known"),
        (b"float x", b"float y", "one name"),
        (b"float x", b"float a", "names a, y, z, not x and y"),
        (b"list uchar int", b"list float int", "not known"),
        (b"element face 2", b"element face 3", "data end"),
        (b"element face 2", b"element face 999", "do not fit"),
        (b"element face 2", b"element face 1", "13 bytes more"),
        (b"end_header\n", b"", "no end"),
        (b"comment made here", b"commend made here", "no place"),
    ],
)
def test_a_header_that_lies_is_refused(old: bytes, new: bytes, says: str) -> None:
    assert old in GOOD
    assert says in refused(GOOD.replace(old, new))


@pytest.mark.parametrize("form", sorted(FORMATS))
@pytest.mark.parametrize("vertex", [30, -1, 2**31 - 1])
def test_a_face_with_a_vertex_that_is_not_there_is_refused(form: str, vertex: int) -> None:
    content = ply([("float", name) for name in "xyz"], named(BALL[:, :3]), form, [[0, 1, vertex]])
    assert f"a face has vertex {vertex}" in refused(content)


@pytest.mark.parametrize("form", sorted(FORMATS))
@pytest.mark.parametrize("element", ["vertex", "face", "edge"])
@pytest.mark.parametrize("count", [2**31, 10**12, 10**18, 10**30])
def test_a_lying_count_takes_no_memory(form: str, element: str, count: int) -> None:
    header = f"ply\nformat {form} 1.0\nelement {element} {count}\nproperty float x\nend_header\n"
    tracemalloc.start()
    try:
        refused(header.encode() + bytes(100))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1_000_000


def test_too_many_vertices_are_too_large() -> None:
    with pytest.raises(TooLargeError):
        read(GOOD, 29)


@pytest.mark.parametrize("size", range(0, len(GOOD), 7))
def test_a_file_that_ends_early_is_refused(size: int) -> None:
    with pytest.raises(MalformedInputError):
        read(GOOD[:size])
