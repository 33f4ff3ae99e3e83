"""The picture of a fit, read as XML: its elements lie where the numbers of the fit say."""

import re
from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import ipcore
from ipcore import shapes
from ipcore._typing import FloatArray
from service.formats.picture import trace
from service.formats.picture.facets import Facets
from service.formats.picture.page import plot
from service.formats.picture.plane import HEIGHT, MOST_DOTS, WARNING, WIDTH, Placing, supported
from service.formats.picture.surface import MOST_TRIANGLES
from service.formats.picture.view import View

NAMESPACE = {"svg": "http://www.w3.org/2000/svg"}
TURN = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
CIRCLE = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)
BALL, _ = shapes.sphere().sample(5000)  # so many that no part of the sphere is far from all of them


def step(degree: int, d_dist: float, d_smooth: float) -> ipcore.Step:
    return ipcore.Step(degree, 3, 0, d_dist, d_smooth, 0.1, 0.01, 10.0, 0.1)


def result(
    polynomial: ipcore.ImplicitPolynomial, steps: list[tuple[float, float]], options: ipcore.FitOptions | None = None
) -> ipcore.FitResult:
    """Return a result whose first degree is 1."""
    seen = ipcore.Diagnostics(*steps[-1], 0.1, 0.2, 0.0, 1, ipcore.NormalSource.GIVEN, 1.0)
    trace = tuple(step(k, *measures) for k, measures in enumerate(steps, start=1))
    reason = ipcore.StopReason.CRITERION_MET
    return ipcore.FitResult(polynomial, reason, trace, seen, (), options or ipcore.FitOptions(), "1", "0" * 64)


def flat(steps: list[tuple[float, float]], options: ipcore.FitOptions | None = None) -> ET.Element:
    return parse(plot(result(shapes.circle().polynomial, steps, options), CIRCLE))


def parse(svg: bytes) -> ET.Element:
    return ET.fromstring(svg)  # noqa: S314 - our own output


def at(root: ET.Element, path: str) -> ET.Element:
    found = root.find(path, NAMESPACE)
    assert found is not None, path
    return found


def coordinates(path: ET.Element) -> FloatArray:
    return np.array(re.findall(r"-?[\d.]+", path.attrib["d"]), dtype=float).reshape(-1, 2)


def heights(chart: ET.Element, kind: str) -> list[float]:
    return [float(circle.attrib["cy"]) for circle in chart.iterfind(f"svg:circle[@class='{kind}']", NAMESPACE)]


def threshold(chart: ET.Element) -> float:
    line = at(chart, "svg:path[@class='threshold']").attrib["d"]
    return float(line.split()[1].split("H")[0])


def facets(root: ET.Element) -> FloatArray:
    """Return the corners (K, 3, 2) of the triangles, in px, in the order in which they are painted."""
    group = at(root, ".//svg:g[@id='surface']")
    scale = float(group.attrib["transform"][len("scale(") : -1])
    rows = [re.findall(r"-?\d+", path.attrib["d"]) for path in group.iterfind("svg:path", NAMESPACE)]
    steps = np.array(rows, dtype=float).reshape(-1, 3, 2)
    return scale * steps.cumsum(axis=1)


def times(p: ipcore.ImplicitPolynomial, line: tuple[float, float]) -> ipcore.ImplicitPolynomial:
    """Return p · (x + y·slope − offset), for line = (slope, offset)."""
    slope, offset = line
    terms = {(1, 0): 1.0, (0, 1): slope, (0, 0): -offset}
    a: dict[tuple[int, ...], float] = {}
    for value, powers in zip(p.coefficients.tolist(), p.exponents.tolist(), strict=True):
        for (i, j), factor in terms.items():
            key = (powers[0] + i, powers[1] + j)
            a[key] = a.get(key, 0.0) + factor * value
    return ipcore.ImplicitPolynomial.from_dict(
        p.to_dict() | {"degree": p.degree + 1, "exponents": list(a), "coefficients": list(a.values())}
    )


class TestCard:
    def test_the_headline_says_what_came_out(self) -> None:
        root = flat([(0.5, 0.2), (0.0086, 0.9899)])
        assert "".join(at(root, ".//svg:text[@id='headline']").itertext()) == (
            "degree 2 · 6 coefficients · D_dist 0.0086 · D_smooth 0.990 · criterion-met"
        )

    def test_it_says_what_is_seen_to_those_who_do_not_see_it(self) -> None:
        root = flat([(0.5, 0.2), (0.0086, 0.9899)])
        assert root.attrib["role"] == "img"
        assert at(root, "svg:title").text == "Implicit polynomial of degree 2"
        assert "1: 0.5 and 0.200, 2: 0.0086 and 0.990" in (at(root, "svg:desc").text or "")

    @pytest.mark.parametrize("shape", [shapes.circle(), shapes.torus()], ids=["curve", "surface"])
    def test_the_same_fit_gives_the_same_bytes_which_need_nothing_else(self, shape: shapes.Shape) -> None:
        points, _ = shape.sample(400)
        drawn = result(shape.polynomial, [(0.5, 0.2), (0.001, 0.99)])
        assert plot(drawn, points) == plot(drawn, points)
        assert b"href" not in plot(drawn, points)
        assert b"url(" not in plot(drawn, points)

    def test_a_real_fit(self) -> None:
        fitted = ipcore.fit(CIRCLE)
        trace = at(parse(plot(fitted, CIRCLE)), ".//svg:g[@id='trace']")
        assert len(heights(at(trace, "svg:g[@id='d_dist']"), "step")) == len(fitted.steps)


class TestCurve:
    def test_the_unit_circle_is_a_circle_of_px_in_the_middle(self) -> None:
        # The bounds are ±1.4, the space for them is higher than wide or wider than high.
        curve = coordinates(at(flat([(0.001, 0.99)]), ".//svg:path[@id='curve']"))
        radius = min(WIDTH, HEIGHT) / 2.8
        distances = np.linalg.norm(curve - [WIDTH / 2, HEIGHT / 2], axis=1)
        assert abs(distances - radius).max() < 0.01  # rounded to 0.005 along either axis
        assert len(curve) > 200

    def test_y_points_up(self) -> None:
        high = shapes.circle().polynomial
        high = replace(high, bounds=np.array([[-1.4, -1.4], [1.4, 4.2]]))
        root = parse(plot(result(high, [(0.001, 0.99)]), CIRCLE))
        assert coordinates(at(root, ".//svg:path[@id='curve']"))[:, 1].min() > HEIGHT / 2 - 0.1

    def test_the_dots_are_the_points(self) -> None:
        path = at(flat([(0.001, 0.99)]), ".//svg:g[@id='shape']/svg:path[@class='dots']").attrib["d"]
        dots = np.array(re.findall(r"M([\d.]+) ([\d.]+)h0", path), dtype=float)
        scale = min(WIDTH, HEIGHT) / 2.8
        assert np.allclose(dots, [WIDTH / 2, HEIGHT / 2] + scale * CIRCLE * [1.0, -1.0], atol=0.051)

    def test_many_points_are_thinned_evenly(self) -> None:
        angle = np.linspace(0.0, 2.0 * np.pi, 20_000, endpoint=False)
        many = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        root = parse(plot(result(shapes.circle().polynomial, [(0.001, 0.99)]), many))
        path = at(root, ".//svg:g[@id='shape']/svg:path[@class='dots']").attrib["d"]
        dots = np.array(re.findall(r"M([\d.]+) ([\d.]+)h0", path), dtype=float)
        assert len(dots) == MOST_DOTS
        gaps = np.linalg.norm(np.diff(dots, axis=0), axis=1)
        assert gaps.max() < 1.5 * np.median(gaps)

    def test_a_line_away_from_the_data_is_drawn_as_a_warning(self) -> None:
        root = parse(plot(result(times(shapes.circle().polynomial, (0.0, 1.3)), [(0.001, 0.99)]), CIRCLE))
        stray = at(root, ".//svg:path[@id='stray']")
        scale = min(WIDTH, HEIGHT) / 2.8
        assert stray.attrib["stroke"] == WARNING
        assert abs(coordinates(stray)[:, 0] - (WIDTH / 2 + 1.3 * scale)).max() < 0.01
        distances = np.linalg.norm(coordinates(at(root, ".//svg:path[@id='curve']")) - [WIDTH / 2, HEIGHT / 2], axis=1)
        assert abs(distances - scale).max() < 0.01

    def test_a_branch_that_only_passes_near_the_data_is_a_warning_too(self) -> None:
        # At x = 1.05 the line is within 0.1 mean radii of the circle, but no point of the circle is nearer to it.
        both = times(shapes.circle().polynomial, (0.0, 1.05))
        whole = ipcore.zero_set(both, data=CIRCLE, restrict=False, cap=False)
        held = supported(whole, CIRCLE)
        middle = whole.vertices[whole.cells].mean(axis=1)
        on_line = middle[:, 0] > 1.04
        assert not held[on_line].any()
        assert held[~on_line].all()

    def test_a_quiet_fit_has_no_warning(self) -> None:
        root = flat([(0.001, 0.99)])
        assert at(root, ".//svg:path[@id='stray']").attrib["d"] == ""
        assert "stray" not in "".join(at(root, ".//svg:g[@id='legend']").itertext())

    def test_the_inside_is_filled_up_to_the_walls(self) -> None:
        half = replace(shapes.circle().polynomial, bounds=np.array([[-1.4, -1.4], [0.0, 1.4]]))
        inside = at(parse(plot(result(half, [(0.001, 0.99)]), CIRCLE)), ".//svg:path[@id='inside']").attrib["d"]
        assert inside.count("M") == inside.count("Z") == 1

    def test_without_zero_set_there_are_still_the_points(self) -> None:
        nothing = shapes.circle().polynomial
        nothing = replace(nothing, coefficients=nothing.coefficients + np.eye(6)[0] * 2.0)
        root = parse(plot(result(nothing, [(0.001, 0.99)]), CIRCLE))
        assert at(root, ".//svg:path[@id='curve']").attrib["d"] == ""
        assert at(root, ".//svg:g[@id='shape']/svg:path[@class='dots']").attrib["d"].count("M") == len(CIRCLE)


class TestTrace:
    STEPS = ((0.5, 0.0), (0.05, 0.6), (0.005, 0.98))

    @pytest.mark.parametrize("count", [1, 2, 3, 40])
    def test_a_marker_for_every_step_in_both_charts(self, count: int) -> None:
        root = flat([(2.0**-k, 1.0 - 2.0**-k) for k in range(count)])
        for name in ("d_dist", "d_smooth"):
            chart = at(root, f".//svg:g[@id='{name}']")
            assert len(heights(chart, "step")) == count
            across = [float(c.attrib["cx"]) for c in chart.iterfind("svg:circle[@class='step']", NAMESPACE)]
            assert across == sorted(set(across))
            assert trace.LEFT < across[0] <= across[-1] < trace.WIDTH

    def test_distance_is_logarithmic(self) -> None:
        # Axis from 1 to 0.001: three decades.
        chart, decade = at(flat(list(self.STEPS)), ".//svg:g[@id='d_dist']"), trace.HEIGHT / 3.0
        expected = [-decade * np.log10(d) for d, _ in self.STEPS]
        assert heights(chart, "step") == pytest.approx(expected, abs=0.051)
        assert threshold(chart) == pytest.approx(2.0 * decade, abs=0.051)

    def test_smoothness_is_linear(self) -> None:
        chart = at(flat(list(self.STEPS)), ".//svg:g[@id='d_smooth']")
        expected = [trace.HEIGHT * (1.0 - s) for _, s in self.STEPS]
        assert heights(chart, "step") == pytest.approx(expected, abs=0.051)
        assert threshold(chart) == pytest.approx(0.05 * trace.HEIGHT, abs=0.051)

    def test_thresholds_are_those_of_the_options(self) -> None:
        root = flat(list(self.STEPS), ipcore.FitOptions(t1=0.1, t2=0.5))
        assert threshold(at(root, ".//svg:g[@id='d_dist']")) == pytest.approx(trace.HEIGHT / 3.0, abs=0.051)
        assert threshold(at(root, ".//svg:g[@id='d_smooth']")) == pytest.approx(trace.HEIGHT / 2.0, abs=0.051)
        assert {"t1 = 0.1", "t2 = 0.5"} <= set(at(root, ".//svg:g[@id='trace']").itertext())

    def test_the_chosen_degree_is_ringed_and_always_labelled(self) -> None:
        root = flat([(0.5, 0.2), (0.005, 0.99), *[(0.05, 0.9)] * 36])
        for name in ("d_dist", "d_smooth"):
            chart = at(root, f".//svg:g[@id='{name}']")
            ring = at(chart, "svg:circle[@class='chosen']")
            second = chart.findall("svg:circle[@class='step']", NAMESPACE)[1]
            assert [ring.attrib[k] for k in ("cx", "cy")] == [second.attrib[k] for k in ("cx", "cy")]
            assert len(heights(chart, "chosen")) == 1
        bold = [text.text for text in root.iterfind(".//svg:text[@font-weight='700']", NAMESPACE)]
        assert bold == ["2"]

    @pytest.mark.parametrize("t1", [0.0, 0.01, float("inf")])
    def test_what_is_no_number_or_off_the_axis_is_shown_at_its_end(self, t1: float) -> None:
        inf, nan = float("inf"), float("nan")
        odd = [(inf, nan), (nan, -inf), (0.3, 0.5), (1e300, 0.9), (0.0, 1.0)]
        root = flat(odd, ipcore.FitOptions(t1=t1))
        distance, smoothness = (at(root, f".//svg:g[@id='{name}']") for name in ("d_dist", "d_smooth"))
        down = heights(distance, "step")
        bottom = trace.HEIGHT
        assert [down[0], down[1], down[3], down[4]] == [0.0, 0.0, 0.0, bottom]
        assert 0.0 < down[2] < bottom
        assert heights(smoothness, "step")[:2] == [bottom, bottom]
        hollow = [c.attrib["fill"] == "#fff" for c in distance.iterfind("svg:circle[@class='step']", NAMESPACE)]
        assert hollow == [True, True, False, True, True]
        assert (distance.find("svg:path[@class='threshold']", NAMESPACE) is not None) == (t1 == 0.01)

    @pytest.mark.parametrize("measures", [(0.0, 1.0), (float("nan"), float("nan")), (1e-16, -1.0), (1.0, 1.0)])
    @pytest.mark.parametrize("options", [ipcore.FitOptions(), ipcore.FitOptions(t1=0.0, t2=1.0)], ids=["default", "0"])
    def test_one_step_of_any_kind(self, measures: tuple[float, float], options: ipcore.FitOptions) -> None:
        root = flat([measures], options)
        for name in ("d_dist", "d_smooth"):
            (y,) = heights(at(root, f".//svg:g[@id='{name}']"), "step")
            assert 0.0 <= y <= trace.HEIGHT


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
