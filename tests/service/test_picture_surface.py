"""The picture of a surface, read as XML: triangles, their light and their order."""

import re
from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import ipcore
from ipcore import shapes
from ipcore._typing import FloatArray
from service.formats.picture.facets import Facets
from service.formats.picture.page import plot
from service.formats.picture.plane import HEIGHT, MOST_DOTS, WIDTH, Placing
from service.formats.picture.surface import MOST_TRIANGLES
from service.formats.picture.view import View
from tests.service.pictures import NAMESPACE, at, parse, result

BALL, _ = shapes.sphere().sample(5000)  # so many that no part of the sphere is far from all of them


def facets(root: ET.Element) -> FloatArray:
    """Return the corners (K, 3, 2) of the triangles, in px, in the order in which they are painted."""
    group = at(root, ".//svg:g[@id='surface']")
    scale = float(group.attrib["transform"][len("scale(") : -1])
    rows = [re.findall(r"-?\d+", path.attrib["d"]) for path in group.iterfind("svg:path", NAMESPACE)]
    steps = np.array(rows, dtype=float).reshape(-1, 3, 2)
    return scale * steps.cumsum(axis=1)


class TestSurface:
    @pytest.mark.parametrize("shape", shapes.SURFACES, ids=lambda shape: shape.__name__)
    def test_triangles_lie_in_their_half_and_turn_their_outside(self, shape: Callable[[], shapes.Shape]) -> None:
        made = shape()
        points, _ = made.sample(5000)
        svg = plot(result(made.polynomial, [(0.001, 0.99)]), points)
        corners = facets(parse(svg))
        assert 3000 < len(corners) <= 1.2 * MOST_TRIANGLES
        assert len(svg) < 700_000
        assert corners.min() >= 0.0
        assert (corners <= [WIDTH, HEIGHT]).all()
        first, second = (corners[:, k] - corners[:, 0] for k in (1, 2))
        assert (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] < 0.0).all()  # clockwise, with y down

    def test_a_sphere_is_a_disc_lit_from_above(self) -> None:
        root = parse(plot(result(shapes.sphere().polynomial, [(0.001, 0.99)]), BALL))
        corners = facets(root)
        radius = np.linalg.norm(corners - [WIDTH / 2, HEIGHT / 2], axis=2)
        assert radius.max() == pytest.approx(HEIGHT / 2 - 8.0, abs=0.5)
        group = at(root, ".//svg:g[@id='surface']")
        shade = np.array([int(path.attrib["class"][1:]) for path in group.iterfind("svg:path", NAMESPACE)])
        up = corners.mean(axis=1)[:, 1] < HEIGHT / 2
        assert shade[up].mean() > shade[~up].mean() + 10
        assert {path.attrib["class"] for path in group} <= set(
            re.findall(r"\.(\w+){", at(root, ".//svg:style").text or "")
        )

    def test_painted_from_far_to_near(self) -> None:
        torus, view = shapes.torus().polynomial, View("z", 20.0, 15.0)
        mesh = ipcore.zero_set(torus, resolution=24)
        seen = mesh.vertices @ view.axes().T
        place = Placing(np.zeros(2), 100.0, np.array([200.0, 200.0]))
        painted = Facets.of(mesh.cells, seen, place)
        assert (np.diff(painted.depth) >= 0.0).all()
        assert np.allclose(seen[painted.cells, 2].mean(axis=1), painted.depth)
        assert np.allclose(painted.corners / 10.0, place(seen[:, :2])[painted.cells], atol=0.051)
        assert painted.outside.all()
        assert 0.4 < len(painted.cells) / len(mesh.cells) < 0.6

    def test_an_open_surface_shows_its_inside_too(self) -> None:
        bowl = BALL[BALL[:, 1] < -0.2]
        drawn = result(shapes.sphere().polynomial, [(0.001, 0.99)])
        group = at(parse(plot(drawn, bowl, View(elevation=40.0))), ".//svg:g[@id='surface']")
        sides = {path.attrib["class"][0] for path in group.iterfind("svg:path", NAMESPACE)}
        assert sides == {"o", "i"}

    def test_a_plane_is_seen_from_both_sides(self) -> None:
        tilted = ipcore.ImplicitPolynomial(
            1, np.array([0.0, 1.0, 2.0, 3.0]), ipcore.Frame(np.zeros(3), 1.0), np.array([[-1.0] * 3, [1.0] * 3])
        )
        x, y = np.random.default_rng(0).uniform(-0.8, 0.8, (2, 500))
        points = np.stack([x, y, -(x + 2.0 * y) / 3.0], axis=1)
        for azimuth in (30.0, 210.0):
            root = parse(plot(result(tilted, [(0.001, 0.99)]), points, View("z", azimuth)))
            assert len(facets(root)) > 100

    def test_without_zero_set_there_are_still_the_points(self) -> None:
        nothing = shapes.sphere().polynomial
        nothing = replace(nothing, coefficients=nothing.coefficients + np.eye(10)[0] * 2.0)
        root = parse(plot(result(nothing, [(0.001, 0.99)]), BALL))
        assert len(facets(root)) == 0
        assert at(root, ".//svg:path[@class='dots']").attrib["d"].count("M") == MOST_DOTS

    @pytest.mark.parametrize("up", ["y", "z"])
    def test_a_view_is_a_rotation_and_up_stays_up(self, up: str) -> None:
        axes = View("y" if up == "y" else "z", 30.0, 20.0).axes()
        eps = float(np.finfo(float).eps)
        assert np.allclose(axes @ axes.T, np.eye(3), atol=4 * eps)
        assert np.linalg.det(axes) == pytest.approx(1.0)
        right, upward, towards = axes @ np.eye(3)["xyz".index(up)]
        assert (right, upward, towards) == pytest.approx((0.0, np.cos(np.pi / 9), np.sin(np.pi / 9)), abs=4 * eps)
