"""Content negotiation: the format of the body, and the format of the response."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.exceptions import HTTPException
from starlette.requests import Request

from service.api.negotiation import point_set_format, quality, wants_file, zero_set_format


def request(**headers: str) -> Request:
    raw = [(name.replace("_", "-").encode(), value.encode("latin-1")) for name, value in headers.items()]
    return Request({"type": "http", "headers": raw})


@pytest.mark.parametrize(
    ("accept", "dimension", "kind"),
    [
        ("*/*", 3, "glb"),
        ("*/*", 2, "svg"),
        ("model/*", 3, "glb"),
        ("model/stl", 3, "stl"),
        ("MODEL/STL", 3, "stl"),
        ("model/ply;q=0.5, model/obj;q=0.7", 3, "obj"),
        ("model/*;q=0.5, model/obj", 3, "obj"),
        ("*/*;q=0.1, model/gltf-binary;q=0", 3, "ply"),
        ("application/x-ply", 3, "ply"),
        ("application/geo+json, image/svg+xml;q=0.9", 2, "geojson"),
        ("text/html, */*;q=0.1", 2, "svg"),
    ],
)
def test_the_best_format_is_chosen(accept: str, dimension: int, kind: str) -> None:
    assert zero_set_format(request(accept=accept), dimension).name == kind


@pytest.mark.parametrize(
    "accept", ["text/html", "image/svg+xml", "*/*;q=0", "model/stl;q=0", "model/stl;q=x", "", ";,="]
)
def test_what_a_surface_cannot_be_had_as_is_406(accept: str) -> None:
    with pytest.raises(HTTPException) as caught:
        zero_set_format(request(accept=accept), 3)
    assert caught.value.status_code == 406


def test_the_name_wins_over_accept() -> None:
    assert zero_set_format(request(accept="model/stl"), 3, "obj").name == "obj"


@pytest.mark.parametrize(
    ("accept", "wanted"),
    [
        ("*/*", False),
        ("application/json", False),
        ("text/html", False),
        ("model/stl", True),
        ("application/json, model/stl", False),
        ("application/json;q=0.5, model/stl", True),
        ("model/*, application/json;q=0.9", True),
    ],
)
def test_a_file_is_the_answer_only_when_wanted_more_than_json(accept: str, wanted: bool) -> None:
    assert wants_file(request(accept=accept)) is wanted


@pytest.mark.parametrize(
    ("sent", "named", "kind"),
    [
        ("application/json", None, "json"),
        ("application/json; charset=utf-8", None, "json"),
        ("Application/X-NPY", None, "npy"),
        ("application/octet-stream", "npy", "npy"),
        ("application/x-npy", "json", "json"),
    ],
)
def test_the_kind_of_the_body(sent: str, named: str | None, kind: str) -> None:
    assert point_set_format(request(content_type=sent), named) == kind


def test_a_body_without_a_type_is_json() -> None:
    assert point_set_format(request(), None) == "json"


@given(st.text(st.characters(codec="latin-1"), max_size=60))
def test_no_header_breaks_it(header: str) -> None:
    assert 0.0 <= quality(header, "model/stl") <= 1.0
    assert isinstance(wants_file(request(accept=header)), bool)
    try:
        point_set_format(request(content_type=header, content_encoding=header), None)
    except HTTPException as error:
        assert error.status_code == 415  # noqa: PT017 - or none at all


def test_of_an_accept_header_the_first_64_ranges_count() -> None:
    ranges = ["a/b"] * 63
    assert quality(",".join([*ranges, "model/ply"]), "model/ply") == 1.0
    assert quality(",".join([*ranges, "a/b", "model/ply"]), "model/ply") == 0.0
    assert quality("," * 1_000_000, "model/ply") == 0.0
