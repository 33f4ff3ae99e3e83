"""OFF: with and without faces, normals and colours."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.service.points.geometry import FACES, QUICK, VERTICES, gives, read, refused, rows


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
    same_line: bool,
    edges: str,
    comments: bool,
    end: str,
    faces: bool,
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
