"""Reading npy files without trusting a byte."""

import struct
import tracemalloc
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from service.formats.points import decode
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError
from tests.service.bodies import Array, ellipse, npy, sphere
from tests.service.readers import read, refused


def header(text: str, data: bytes = b"", version: tuple[int, int] = (1, 0)) -> bytes:
    length = struct.pack("<H" if version == (1, 0) else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + length + text.encode("latin-1") + data


def described(shape: str = "(20, 2)", kind: str = "'<f8'", order: str = "False") -> str:
    return f"{{'descr': {kind}, 'fortran_order': {order}, 'shape': {shape}, }}\n"


@pytest.mark.parametrize(
    "table",
    [ellipse(), sphere()[:, :3], sphere(), np.hstack([ellipse(), 8.0 * (ellipse() - [2.5, 1.0]) / [1.0, 0.72]])],
)
def test_what_was_read_splits_into_what_was_sent(table: Array) -> None:
    found = read(npy(table), "npy")
    points, normals = decode.split(found.content, found.dimension)
    assert np.array_equal(points, table[:, : found.dimension])
    assert (normals is None) == (table.shape[1] <= 3)
    if normals is not None:
        sent = table[:, found.dimension :]
        assert np.allclose(normals, sent / np.linalg.norm(sent, axis=1, keepdims=True), atol=1e-15)


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"\x93NUMPY",
        b"\x93NUMPY\x01\x00",
        npy(ellipse(20))[:-1],
        npy(ellipse(20)) + b"\0",
        npy(ellipse(20))[:40],
        b"\x94NUMPY" + npy(ellipse(20))[6:],
        header(described(), ellipse(20).tobytes(), (3, 0)),
        header(described(), ellipse(20).tobytes(), (9, 9)),
        header(described("(20, 10**12)")),
        header(described("(20, 1000000000000)")),
        header(described(kind="'|O'"), b"cos\nsystem\n."),
        header(described(kind="'<c16'"), ellipse(20).tobytes()),
        header(described(kind="('<f8', (1000000000,))")),
        header(described(order="5"), ellipse(20).tobytes()),
        header("{'descr': '<f8'}"),
        header("((((((((("),
        header("(" * 9000),
        header("'unended"),
        header("{**1}"),
        header("__import__('os')"),
        header("\0\0\0"),
        npy(np.array([object(), None], dtype=object)),
    ],
)
def test_npy_that_is_none_is_malformed(body: bytes) -> None:
    assert isinstance(refused(body, "npy"), MalformedInputError)


def test_a_lying_header_takes_no_memory() -> None:
    tracemalloc.start()
    try:
        assert isinstance(refused(header(described("(1000000000000, 2)")), "npy"), TooLargeError)
        refused(header(described("(2, 1000000000000)")), "npy")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1_000_000


@pytest.mark.parametrize("shape", [(20,), (5, 2, 2), (), (20, 1), (20, 5), (0, 2), (20, 0)])
def test_npy_of_another_shape_is_refused(shape: tuple[int, ...]) -> None:
    assert refused(npy(np.ones(shape)), "npy").at == ("points",)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_none_is_named(bad: float) -> None:
    table = ellipse(20)
    table[17, 1] = bad
    assert refused(npy(table), "npy").at == ("points", 17, 1)


@settings(deadline=None, max_examples=300)
@given(st.integers(0, 200), st.binary(min_size=1, max_size=8))
@example(8, b"\xff\xff")
def test_no_damage_breaks_the_npy_reader(at: int, damage: bytes) -> None:
    whole = npy(ellipse(20))
    with suppress(InvalidInputError):
        read(whole[:at] + damage + whole[at + len(damage) :], "npy")


@settings(deadline=None, max_examples=200)
@given(st.text(alphabet="(){}[]'\",:<>|fiuOV0123456789 \n\\descrhapotn_TrueFals", max_size=80))
def test_no_header_breaks_the_npy_reader(text: str) -> None:
    assert isinstance(refused(header(text), "npy"), InvalidInputError)
