"""JSON: nesting without end, values that are no numbers, and byte order marks."""

import base64
import json

import pytest

from service.jobs.errors import MalformedInputError
from tests.service.points.arrays import OUTLINE, gives, read, refused


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
def test_json_with_a_byte_order_mark_is_read(mark: bytes, packed: bool) -> None:
    array = {"dtype": "<f8", "shape": [20, 2], "data": base64.b64encode(OUTLINE.tobytes()).decode()}
    body = json.dumps({"points": array if packed else OUTLINE.tolist()}).encode()
    assert gives(read(mark + body, "json"), OUTLINE)


@pytest.mark.parametrize(
    "body", [b"\xef\xbb\xbf", b"\xef\xbb\xbf\xef\xbb\xbf{}", b"{}\xef\xbb\xbf", b"\xff\xfe{\x00}\x00"]
)
def test_a_byte_order_mark_alone_makes_no_json(body: bytes) -> None:
    assert isinstance(refused(body, "json"), MalformedInputError)
