"""npy and npz: fields by name, what is no real number, and shapes that lie."""

import base64
import json
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.errors import MalformedInputError
from tests.service.bodies import npy
from tests.service.points.arrays import BALL, NAMES, OUTLINE, QUICK, gives, npz, read, records, refused

NUMBERS = ["<f8", ">f8", "<f4", ">f4", "<i4", ">i2", "<u8", "|u1", "|i1", "<f2"]


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
    upper: bool,
    archived: bool,
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
def test_integers_and_floats_of_either_byte_order_are_read(kind: str, d: int, order: Any) -> None:  # noqa: ANN401 - numpy's own type is a literal
    table = np.round(20.0 * BALL[:, :d] + 30.0).astype(kind)
    assert gives(read(npy(table, order)), table.astype(float))
    assert gives(read(npz(points=table), "npz"), table.astype(float))


@pytest.mark.parametrize("kind", ["<c8", "<c16", ">c16", "|b1", "<U5", "|S5", "<M8[s]", "<m8[s]", "<f16", "|V8", "|O"])
@pytest.mark.parametrize("archived", [False, True])
def test_what_is_no_real_number_is_refused(kind: str, archived: bool) -> None:
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
def test_a_shape_that_lies_is_refused(shape: tuple[int, ...], order: bool, packed: bool) -> None:
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
