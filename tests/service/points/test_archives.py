"""npz: which array is what, what is packed, and damage."""

import zipfile
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.errors import InvalidInputError, TooLargeError
from tests.service.bodies import Array, npy
from tests.service.points.arrays import BALL, OUTLINE, QUICK, gives, npz, read, records, refused, saved


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("name", ["points", "arr_0", "vertices", "Ünit"])
def test_one_array_of_an_archive_may_have_any_name(name: str, compressed: bool) -> None:
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
