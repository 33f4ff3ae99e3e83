"""Curve files, read back as XML and as JSON."""

import json
import re
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.zero_set import ZeroSet, zero_set
from service.formats.zero_set.geojson import write as geojson
from service.formats.zero_set.svg import write as svg

SQUARE = np.array([[-2.0, -2.0], [2.0, 2.0]])


def quartic(terms: dict[tuple[int, int], float]) -> ImplicitPolynomial:
    a = np.zeros(graded.count(2, 4))
    a[graded.column(np.array(list(terms)))] = list(terms.values())
    return ImplicitPolynomial(4, a, Frame(np.zeros(2), 1.0), SQUARE)


# (r² − 1)(r² − 1/4), negative between the circles; and its negative
ANNULUS = quartic({(0, 0): 0.25, (2, 0): -1.25, (0, 2): -1.25, (4, 0): 1.0, (2, 2): 2.0, (0, 4): 1.0})
# Cassini's ovals about (±1, 0) with product of distances 0.8
OVALS = quartic({(0, 0): 1 - 0.8**2, (2, 0): -2.0, (0, 2): 2.0, (4, 0): 1.0, (2, 2): 2.0, (0, 4): 1.0})


def circle(shift: float = 0.0) -> ZeroSet:
    p = shapes.ellipse(1.0, 0.5).polynomial
    return zero_set(ImplicitPolynomial(2, p.coefficients, Frame(p.frame.centre + shift, 1.0), p.bounds + shift))


def area(ring: list[list[float]] | FloatArray) -> float:
    x, y = np.array(ring).T
    return float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) / 2.0


def read(z: ZeroSet) -> tuple[dict[str, Any], Any]:
    feature = json.loads(geojson(z))
    assert feature["type"] == "Feature"
    return feature, feature["geometry"]


def path(root: ET.Element) -> ET.Element:
    (element,) = root.iter("{http://www.w3.org/2000/svg}path")
    return element


def test_geojson_of_a_circle_is_a_polygon_with_the_coordinates_to_the_bit() -> None:
    z = circle()
    feature, geometry = read(z)
    assert geometry["type"] == "Polygon"
    assert (np.array(geometry["coordinates"][0]) == z.polylines()[0]).all()
    assert feature["bbox"] == [*z.vertices.min(axis=0), *z.vertices.max(axis=0)]
    assert feature["properties"]["components"] == 1
    assert feature["properties"]["stray"] is None


def test_geojson_gives_holes_to_the_ring_round_them_by_the_right_hand_rule() -> None:
    _, geometry = read(zero_set(ANNULUS))
    assert geometry["type"] == "Polygon"
    outer, hole = map(area, geometry["coordinates"])
    assert [outer, hole] == pytest.approx([np.pi, -np.pi / 4], rel=1e-3)


def test_geojson_of_an_island_in_a_hole_is_two_polygons() -> None:
    inverse = ImplicitPolynomial(4, -ANNULUS.coefficients, ANNULUS.frame, SQUARE)
    _, geometry = read(zero_set(inverse))
    assert geometry["type"] == "MultiPolygon"
    areas = sorted([area(ring) for ring in polygon] for polygon in geometry["coordinates"])
    assert areas[0] == pytest.approx([np.pi / 4], rel=1e-3)
    assert areas[1] == pytest.approx([16.0, -np.pi], rel=1e-3)


def test_geojson_of_two_ovals_is_two_polygons() -> None:
    feature, geometry = read(zero_set(OVALS))
    assert geometry["type"] == "MultiPolygon"
    assert [len(polygon) for polygon in geometry["coordinates"]] == [1, 1]
    assert feature["properties"]["components"] == 2


def test_geojson_of_open_lines_or_of_holes_alone_is_lines() -> None:
    p = shapes.circle().polynomial
    _, cut = read(zero_set(p, np.array([[0.0, -2.0], [2.0, 2.0]]), cap=False))
    assert cut["type"] == "MultiLineString"
    outside = ImplicitPolynomial(2, -p.coefficients, p.frame, p.bounds)
    _, hole = read(zero_set(outside, cap=False))
    assert hole["type"] == "MultiLineString"
    assert area(hole["coordinates"][0]) == pytest.approx(-np.pi, rel=1e-3)


def test_svg_draws_the_curve_upright_about_its_middle() -> None:
    z = circle(shift=1e6)
    root = ET.fromstring(svg(z))  # noqa: S314 - our own output
    left, top, width, height = map(float, root.attrib["viewBox"].split())
    assert (left, top, width, height) == pytest.approx((-1.1, -0.6, 2.2, 1.2), rel=1e-4)
    drawing = path(root)
    assert drawing.attrib["transform"] == "scale(1 -1)"
    assert drawing.attrib["d"].endswith("Z")
    points = np.array(re.findall(r"[-+.\de]+", drawing.attrib["d"]), dtype=float).reshape(-1, 2)
    origin = np.array(root.attrib["data-origin"].split(), dtype=float)
    assert np.abs(points + origin - z.polylines()[0][:-1]).max() < 1e-6


def test_svg_draws_every_line_in_one_path() -> None:
    assert path(ET.fromstring(svg(zero_set(OVALS)))).attrib["d"].count("M") == 2  # noqa: S314 - our own
    half = zero_set(shapes.circle().polynomial, np.array([[0.0, -2.0], [2.0, 2.0]]), cap=False)
    assert "Z" not in path(ET.fromstring(svg(half))).attrib["d"]  # noqa: S314 - our own


def test_no_curve_is_an_empty_picture_and_no_geometry() -> None:
    nothing = zero_set(shapes.circle().polynomial, np.array([[2.0, 2.0], [3.0, 3.0]]))
    assert not path(ET.fromstring(svg(nothing))).attrib["d"]  # noqa: S314 - our own
    feature, geometry = read(nothing)
    assert geometry is None
    assert "bbox" not in feature
