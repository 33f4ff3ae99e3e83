"""Reading point sets in JSON without trusting a byte."""

import base64
import json
import tracemalloc
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from tests.service.bodies import ellipse
from tests.service.readers import read, refused

POINTS = ellipse(20).tolist()


def test_options_are_handed_on_as_they_are() -> None:
    assert read({"points": POINTS, "options": {"max_degree": 3}}).options == {"max_degree": 3}


@pytest.mark.parametrize(
    ("points", "at"),
    [
        ([], ("points",)),
        ([[]], ("points",)),
        ([1.0, 2.0], ("points", 0)),
        ([[1.0, 2.0], [3.0]], ("points", 1)),
        ([*POINTS, None], ("points", 20)),
        ([*POINTS, [None, 1.0]], ("points", 20, 0)),
        ([*POINTS, [1.0, "2"]], ("points", 20, 1)),
        ([*POINTS, [1.0, True]], ("points", 20, 1)),
        ([*POINTS, [1.0, [2.0]]], ("points", 20, 1)),
        ([*POINTS, [1.0, {}]], ("points", 20, 1)),
        ("points", ("points",)),
        (None, ("points",)),
        (5, ("points",)),
        ([[1.0, 2.0, 3.0, 4.0, 5.0]] * 9, ("points",)),
        ([[1.0]] * 9, ("points",)),
        (POINTS[:2], ("points",)),
        ([POINTS[0]] * 9, ("points",)),
        ([[float(i), 2.0 * i] for i in range(9)], ("points",)),
        ([[float(i), 2.0 * i, 3.0 * i] for i in range(9)], ("points",)),
        ([*POINTS, [1e400, 0.0]], ("points", 20, 0)),
        ([*POINTS, [1e300, 0.0]], ("points",)),
    ],
)
def test_points_that_are_none_are_refused_with_their_place(points: object, at: tuple[str | int, ...]) -> None:
    body = json.dumps({"points": points}).replace("Infinity", "1e400").encode()
    error = refused(body)
    assert isinstance(error, MalformedInputError) or error.at == at  # a number too large for a double may be no JSON


def test_huge_integers_are_numbers_or_refused() -> None:
    assert read({"points": [*POINTS, [2**63, 2**60], [-(2**63), 0]]}).points == 22
    refused(json.dumps({"points": [*POINTS, [10**400, 0]]}).encode())


@pytest.mark.parametrize(
    ("normals", "at"),
    [
        (POINTS[:-1], ("normals",)),
        ([[1.0, 0.0, 0.0]] * 20, ("normals",)),
        ([[1.0, 0.0]] * 19 + [[0.0, 0.0]], ("normals", 19)),
        ([[1.0, 0.0]] * 19 + [[0.0, "1"]], ("normals", 19, 1)),
        ([], ("normals",)),
        (True, ("normals",)),
    ],
)
def test_normals_that_do_not_belong_are_refused(normals: object, at: tuple[str | int, ...]) -> None:
    assert refused({"points": POINTS, "normals": normals}).at == at


@pytest.mark.parametrize(
    "body",
    [b"", b"{", b"nul", b"\xff\xfe", b'{"points": [[1,2],[3,\xc3\x28]]}', b"[" * 100_000, b'{"points": NaN}', b"{}}"],
)
def test_what_is_not_json_is_malformed(body: bytes) -> None:
    assert isinstance(refused(body), MalformedInputError)


@pytest.mark.parametrize("body", [b"[]", b"5", b"null", b'"points"', b"{}", b'{"options": {}}'])
def test_json_without_points_is_refused(body: bytes) -> None:
    assert not isinstance(refused(body), MalformedInputError)


@pytest.mark.parametrize("options", [None, [], 0, "", False, "max_degree"])
def test_options_must_be_an_object(options: object) -> None:
    assert refused({"points": POINTS, "options": options}).at == ("options",)


def test_an_unknown_member_is_named_but_not_told_back_in_full() -> None:
    error = refused({"points": POINTS, "x" * 1000: 1})
    assert str(error).startswith("unknown member 'xxx")
    assert len(str(error)) < 200


def test_a_doubled_key_counts_once() -> None:
    assert read(b'{"points": 5, "points": ' + json.dumps(POINTS).encode() + b"}").points == 20


def test_a_long_string_among_the_points_takes_no_memory() -> None:
    body = json.dumps({"points": [["x" * 1_000_000, 1.0], *POINTS * 40]}).encode()
    tracemalloc.start()
    try:
        assert refused(body).at == ("points", 0, 0)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 20_000_000


PACKED = {"dtype": "<f8", "shape": [20, 2], "data": base64.b64encode(ellipse(20).tobytes()).decode()}


def test_packed_arrays_are_read() -> None:
    assert read({"points": PACKED}).content == read({"points": POINTS}).content


@pytest.mark.parametrize(
    "change",
    [
        {"dtype": "object"},
        {"dtype": "|O"},
        {"dtype": "<c16"},
        {"dtype": "f8,f8"},
        {"dtype": "(1000000000,)f8"},
        {"dtype": "<M8[s]"},
        {"dtype": "|b1"},
        {"dtype": "<f16"},
        {"dtype": "x" * 10_000},
        {"dtype": None},
        {"dtype": ["<f8"]},
        {"shape": [20]},
        {"shape": [20, 2, 1]},
        {"shape": [-20, -2]},
        {"shape": [20.0, 2.0]},
        {"shape": ["20", "2"]},
        {"shape": [True, 40]},
        {"shape": [20, 10**12]},
        {"shape": [19, 2]},
        {"shape": None},
        {"shape": {"0": 20}},
        {"data": ""},
        {"data": "%%%%"},
        {"data": "é"},
        {"data": 5},
        {"extra": 5},
    ],
)
def test_packed_arrays_that_are_none_are_refused(change: dict[str, Any]) -> None:
    assert refused({"points": PACKED | change}).at[0] == "points"


@pytest.mark.parametrize("body", [{"points": {**PACKED, "shape": [10**12, 2]}}, {"points": POINTS * 51}])
def test_too_many_points_are_too_large(body: dict[str, Any]) -> None:
    assert isinstance(refused(body), TooLargeError)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=20,
)


@settings(deadline=None, max_examples=200, suppress_health_check=[HealthCheck.too_slow])
@given(points=JSON, normals=JSON, options=JSON)
def test_no_json_breaks_the_reader(points: object, normals: object, options: object) -> None:
    body = {"points": points, "normals": normals, "options": options}
    with suppress(InvalidInputError):
        assert read(body).points >= 3
