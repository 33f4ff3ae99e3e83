"""npy, npz and JSON: fields by name, what is no real number, shapes that lie, and nesting without end."""

import base64
import json
import zipfile
from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.formats.points import decode
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from service.jobs.fit import PointSet
from service.jobs.media_types import Missing
from tests.service.bodies import Array, ellipse, npy, sphere

BALL = sphere(30)
OUTLINE = ellipse(20)
NAMES = ("x", "y", "z", "nx", "ny", "nz")
QUICK = settings(deadline=None, max_examples=60)
NUMBERS = ["<f8", ">f8", "<f4", ">f4", "<i4", ">i2", "<u8", "|u1", "|i1", "<f2"]


def read(content: bytes, kind: str = "npy", columns: str | None = None, missing: Missing = "refuse") -> PointSet:
    return decode.read(content, kind, 1000, columns=columns, missing=missing)


def refused(content: bytes, kind: str = "npy", columns: str | None = None) -> InvalidInputError:
    with pytest.raises(InvalidInputError) as caught:
        read(content, kind, columns)
    return caught.value


def npz(**arrays: Array) -> bytes:
    return saved(arrays, np.savez)


def saved(arrays: dict[str, Array], save: Callable[..., None]) -> bytes:
    file = BytesIO()
    save(file, **arrays)
    return file.getvalue()


def records(table: Array, names: list[str], kinds: list[str], more: list[tuple[str, str]]) -> Array:
    made = np.zeros(len(table), dtype=[*zip(names, kinds, strict=True), *more])
    for i, name in enumerate(names):
        made[name] = table[:, i]
    return made


def gives(found: PointSet, points: Array, normals: Array | None = None, within: float = 1e-15) -> bool:
    x, n = decode.split(found.content, found.dimension)
    if (n is None) != (normals is None):
        return False
    return np.allclose(x, points, atol=within) and (
        n is None or normals is None or np.allclose(n, normals, atol=within)
    )


# Records


@QUICK
@given(
    order=st.permutations(range(6)),
    kinds=st.lists(st.sampled_from(["<f8", ">f8", "<f4", ">f4"]), min_size=6, max_size=6),
    more=st.lists(st.sampled_from([("red", "|u1"), ("label", "<U5"), ("ok", "|b1"), ("t", "<M8[s]")]), unique=True),
    upper=st.booleans(),
    archived=st.booleans(),
)
def test_records_are_read_by_the_names_of_their_fields(
    order: list[int],
    kinds: list[str],
    more: list[tuple[str, str]],
    upper: bool,  # noqa: FBT001 - drawn
    archived: bool,  # noqa: FBT001
) -> None:
    names = [NAMES[i].upper() if upper else NAMES[i] for i in order]
    made = records(BALL[:, order], names, kinds, more)
    found = read(npz(points=made), "npz") if archived else read(npy(made))
    assert gives(found, BALL[:, :3], BALL[:, 3:], 1e-6)


@pytest.mark.parametrize("names", [("x", "y"), ("y", "x"), ("x", "y", "z"), ("z", "y", "x"), ("Y", "Z", "X")])
@pytest.mark.parametrize("shape", [(30,), (30, 1)])
def test_records_of_points_alone(names: tuple[str, ...], shape: tuple[int, ...]) -> None:
    order = ["xyz".index(name.lower()) for name in names]
    made = records(BALL[:, order], list(names), ["<f8"] * len(names), []).reshape(shape)
    assert gives(read(npy(made)), BALL[:, : len(names)])


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ([("a", "<f8"), ("b", "<f8")], "the dtype names a, b, not x and y"),
        ([("x", "<f8"), ("y", "<c16")], "field 'y': dtype must be an integer or a float of at most 8 bytes, not <c16"),
        ([("x", "<f8"), ("y", "<U9")], "field 'y': dtype must be"),
        ([("x", "|b1"), ("y", "<f8")], "field 'x': dtype must be"),
        ([("x", "|O"), ("y", "<f8")], "Python objects"),
        ([("x", "<f8"), ("y", "<f8"), ("t", "|O")], "Python objects"),
        ([("x", "<f8", (2,)), ("y", "<f8")], "field 'x': dtype must be"),
        ([("x", "<f8"), ("y", "<f8"), ("nx", "<f8")], "normals need nx, ny"),
        ([("x", "<f8"), ("y", "<f8"), ("X", "<f8")], "names x more than once"),
    ],
)
def test_records_that_do_not_make_points_are_refused_in_full_sentences(fields: list[Any], says: str) -> None:
    file = BytesIO()
    np.save(file, np.zeros(30, dtype=fields), allow_pickle=True)
    error = refused(file.getvalue())
    assert says in str(error)
    assert not str(error).endswith("…")


def test_columns_says_what_the_fields_of_records_are() -> None:
    made = records(OUTLINE, ["lat", "lon"], ["<f8", "<f8"], [("t", "<f8")])
    assert gives(read(npy(made), columns="y,x,_"), OUTLINE[:, ::-1])


# Arrays


@pytest.mark.parametrize("kind", NUMBERS)
@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("order", ["C", "F"])
def test_integers_and_floats_of_either_byte_order_are_read(kind: str, d: int, order: Any) -> None:  # noqa: ANN401
    table = np.round(20.0 * BALL[:, :d] + 30.0).astype(kind)
    assert gives(read(npy(table, order)), table.astype(float))
    assert gives(read(npz(points=table), "npz"), table.astype(float))


@pytest.mark.parametrize("kind", ["<c8", "<c16", ">c16", "|b1", "<U5", "|S5", "<M8[s]", "<m8[s]", "<f16", "|V8", "|O"])
@pytest.mark.parametrize("archived", [False, True])
def test_what_is_no_real_number_is_refused(kind: str, archived: bool) -> None:  # noqa: FBT001 - of the table
    table = np.zeros((30, 3), dtype=kind)
    error = refused(npz(points=table), "npz") if archived else refused(npy(table))
    assert isinstance(error, MalformedInputError)
    assert not str(error).endswith("…")


def test_complex_numbers_are_refused_with_what_to_send() -> None:
    assert "coordinates are real: send the real part" in str(refused(npy(OUTLINE.astype(complex))))


@pytest.mark.parametrize("kind", ["npy", "npz"])
def test_columns_settles_an_array_that_could_be_two_things(kind: str) -> None:
    table = np.hstack([BALL[:, :3], np.linspace(1.0, 240.0, 30)[:, None]])
    content = npy(table) if kind == "npy" else npz(points=table)
    assert "columns=x,y,z,_" in str(refused(content, kind))
    assert gives(read(content, kind, "x,y,z,_"), BALL[:, :3])
    assert gives(read(content, kind, "_,y,x,_"), BALL[:, [2, 1]])


@pytest.mark.parametrize("width", [5, 7, 12])
def test_an_array_of_another_width_can_be_named(width: int) -> None:
    table = np.hstack([BALL[:, :3], np.full((30, width - 3), 7.5)])
    assert "columns" in str(refused(npy(table)))
    assert gives(read(npy(table), columns=",".join(["x", "y", "z", *["_"] * (width - 3)])), BALL[:, :3])


@pytest.mark.parametrize("length", [1e-200, 0.01, 1.0, 1.05, 100.0, 1e150])
def test_the_normals_of_an_array_may_have_any_one_length(length: float) -> None:
    normals = length * BALL[:, 3:] * np.linspace(0.95, 1.05, 30)[:, None]
    assert gives(read(npy(np.hstack([BALL[:, :3], normals]))), BALL[:, :3], BALL[:, 3:], 1e-6)
    normals[17] *= 1.3
    assert "whose length would be 1, or one in many directions" in str(refused(npy(np.hstack([BALL[:, :3], normals]))))


HUGE = [2**31, 2**62, 2**63, 2**64, 10**30]


@pytest.mark.parametrize(
    "shape",
    [
        *[shape for n in HUGE for shape in ((0, n), (n, 0), (2, n), (n, 2))],
        *[(True, 2), (True, True), (20, True), (False, 2), (0, 0), (-1, 2), (-20, -2), (20,), (), (20, 2, 1)],
    ],
)
@pytest.mark.parametrize("order", [False, True])
@pytest.mark.parametrize("packed", [False, True])
def test_a_shape_that_lies_is_refused(shape: tuple[int, ...], order: bool, packed: bool) -> None:  # noqa: FBT001
    data = OUTLINE.tobytes()
    for size in (0, len(data)):
        if packed:
            array = {"dtype": "<f8", "shape": list(shape), "data": base64.b64encode(data[:size]).decode()}
            assert refused(json.dumps({"points": array}).encode(), "json").at[0] == "points"
        else:
            literal = f"{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}\n".encode()
            refused(b"\x93NUMPY\x01\x00" + len(literal).to_bytes(2, "little") + literal + data[:size])


@pytest.mark.parametrize("fields", ["[('x', '|V0'), ('y', '|V0')]", "[]", "[('x', '<f8', (0,)), ('y', '<f8', (0,))]"])
@pytest.mark.parametrize("count", [20, 2**62])
def test_records_of_no_bytes_are_refused(fields: str, count: int) -> None:
    literal = f"{{'descr': {fields}, 'fortran_order': False, 'shape': ({count},), }}\n".encode()
    refused(b"\x93NUMPY\x01\x00" + len(literal).to_bytes(2, "little") + literal)


# Archives


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("name", ["points", "arr_0", "vertices", "Ünit"])
def test_one_array_of_an_archive_may_have_any_name(name: str, compressed: bool) -> None:  # noqa: FBT001 - of the table
    content = saved({name: BALL}, np.savez_compressed if compressed else np.savez)
    assert gives(read(content, "npz"), BALL[:, :3], BALL[:, 3:])


@pytest.mark.parametrize("fields", [None, ("nx", "ny", "nz"), ("x", "y", "z"), ("nz", "nx", "ny"), ("NY", "NZ", "NX")])
def test_normals_of_an_archive_stand_beside_the_points(fields: tuple[str, ...] | None) -> None:
    normals = BALL[:, 3:]
    if fields is not None:
        order = ["xyz".index(name[-1].lower()) for name in fields]
        normals = records(BALL[:, [3 + i for i in order]], list(fields), ["<f8"] * 3, [])
    found = read(npz(points=BALL[:, :3], normals=normals, colours=np.zeros(3)), "npz")
    assert gives(found, BALL[:, :3], BALL[:, 3:])


@pytest.mark.parametrize(
    ("arrays", "says"),
    [
        ({"a": OUTLINE, "b": OUTLINE}, "one must be called points; here are a, b"),
        ({}, "one must be called points; here are none"),
        ({"points": BALL, "normals": BALL[:, 3:]}, "normals in two places"),
        ({"points": BALL[:, :3], "normals": BALL[:9, 3:]}, "they must match"),
        ({"points": BALL[:, :3], "normals": BALL[:, 3:].astype(complex)}, "dtype must be"),
        ({"points": BALL[:, :3], "normals": np.zeros(30, dtype=[("nx", "<f8"), ("ny", "<f8")])}, "3 fields"),
        ({"points": np.array(5.0)}, "two axes"),
    ],
)
def test_archives_that_do_not_make_points_are_refused(arrays: dict[str, Array], says: str) -> None:
    assert says in str(refused(npz(**arrays), "npz"))


def test_of_an_archive_no_more_is_unpacked_than_points_can_have() -> None:
    bomb = BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", npy(np.zeros((200_000, 2))))
    assert bomb.tell() < 20_000
    with pytest.raises(TooLargeError):
        read(bomb.getvalue(), "npz")


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_an_archive_that_is_packed_otherwise_is_refused(method: int) -> None:
    file = BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        archive.writestr("points.npy", npy(OUTLINE))
    assert "packed" in str(refused(file.getvalue(), "npz"))


@QUICK
@given(at=st.integers(0, 2000), damage=st.binary(min_size=1, max_size=6))
def test_a_damaged_archive_is_read_or_refused(at: int, damage: bytes) -> None:
    whole = saved({"points": OUTLINE}, np.savez_compressed)
    try:
        read(whole[:at] + damage + whole[at + len(damage) :], "npz")
    except InvalidInputError as error:
        assert str(error)  # noqa: PT017 - nothing else may be raised


# JSON


@pytest.mark.parametrize("depth", [2, 200, 254, 255, 257, 500, 1000, 1023, 1024, 5000, 100_000])
@pytest.mark.parametrize("brackets", [("[", "]"), ('{"a":', "}")])
@pytest.mark.parametrize("place", ["points", "normals", "row", "cell", "options", "data"])
def test_json_nested_to_any_depth_is_refused_or_read(depth: int, brackets: tuple[str, str], place: str) -> None:
    nest = brackets[0] * depth + "1" + brackets[1] * depth
    points = json.dumps(OUTLINE.tolist())
    body = {
        "points": f'{{"points": {nest}}}',
        "normals": f'{{"points": {points}, "normals": {nest}}}',
        "row": f'{{"points": [[0, 1], {nest}]}}',
        "cell": f'{{"points": [[0, 1], [0, {nest}]]}}',
        "options": f'{{"points": {points}, "options": {{"t1": {nest}}}}}',
        "data": f'{{"points": {{"dtype": "<f8", "shape": [1, 2], "data": {nest}}}}}',
    }[place]
    if place == "options" and depth < 1010:
        assert read(body.encode(), "json").points == 20
    else:
        assert len(str(refused(body.encode(), "json"))) < 200


@pytest.mark.parametrize("value", [None, True, "two", "x" * 9999, [], [[[]]], {}, {"a": [1]}, "\ud7ff\U0001f600"])
def test_a_value_that_is_no_number_is_shown(value: object) -> None:
    error = refused(json.dumps({"points": [*OUTLINE.tolist(), [1.0, value]]}).encode(), "json")
    assert error.at == ("points", 20, 1)
    assert "points row 20, column 1 is not a number: " in str(error)
    assert len(str(error)) < 120


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("packed", [False, True])
def test_json_with_a_byte_order_mark_is_read(mark: bytes, packed: bool) -> None:  # noqa: FBT001 - of the table
    array = {"dtype": "<f8", "shape": [20, 2], "data": base64.b64encode(OUTLINE.tobytes()).decode()}
    body = json.dumps({"points": array if packed else OUTLINE.tolist()}).encode()
    assert gives(read(mark + body, "json"), OUTLINE)


@pytest.mark.parametrize(
    "body", [b"\xef\xbb\xbf", b"\xef\xbb\xbf\xef\xbb\xbf{}", b"{}\xef\xbb\xbf", b"\xff\xfe{\x00}\x00"]
)
def test_a_byte_order_mark_alone_makes_no_json(body: bytes) -> None:
    assert isinstance(refused(body, "json"), MalformedInputError)


# Missing values


@pytest.mark.parametrize("kind", ["npy", "npz", "json", "packed"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("columns", [(0,), (1, 4), (5,)])
def test_points_with_missing_values_are_refused_or_left_out(kind: str, bad: float, columns: tuple[int, ...]) -> None:
    table = BALL.copy()
    table[[4, 9], columns[0]] = bad
    table[9, columns[-1]] = bad
    if kind == "json":
        rows = [[value if np.isfinite(value) else None for value in row] for row in table.tolist()]
        content = json.dumps({"points": [r[:3] for r in rows], "normals": [r[3:] for r in rows]}).encode()
    elif kind == "packed":
        halves = {"points": table[:, :3], "normals": table[:, 3:]}
        packed = {
            name: {"dtype": "<f8", "shape": [30, 3], "data": base64.b64encode(half.tobytes()).decode()}
            for name, half in halves.items()
        }
        content = json.dumps(packed).encode()
    else:
        content = npy(table) if kind == "npy" else npz(points=table[:, :3], normals=table[:, 3:])
    name = kind if kind in ("npy", "npz") else "json"
    error = refused(content, name)
    assert error.at[1] == 4
    found = read(content, name, missing="drop")
    kept = np.delete(BALL, [4, 9], axis=0)
    assert found.left_out == 2
    assert gives(found, kept[:, :3], kept[:, 3:])


def test_the_message_about_a_missing_value_says_how_to_leave_it_out() -> None:
    table = OUTLINE.copy()
    table[3, 1] = np.nan
    assert str(refused(npy(table))).endswith("missing=drop leaves such points out")
    assert "missing" not in str(refused(npy(np.ones((9, 2)))))


def test_normals_that_do_not_match_are_refused_even_if_missing_values_are_left_out() -> None:
    body = json.dumps({"points": OUTLINE.tolist(), "normals": OUTLINE[:9].tolist()}).encode()
    with pytest.raises(InvalidInputError, match="they must match"):
        read(body, "json", missing="drop")
