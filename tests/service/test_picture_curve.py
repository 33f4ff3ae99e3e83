"""The picture of a curve, read as XML: its elements lie where the numbers of the fit say."""

import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np

import ipcore
from ipcore import shapes
from ipcore._typing import FloatArray
from service.formats.picture.page import plot
from service.formats.picture.plane import HEIGHT, MOST_DOTS, WARNING, WIDTH, supported
from tests.service.pictures import CIRCLE, at, flat, parse, result


def coordinates(path: ET.Element) -> FloatArray:
    return np.array(re.findall(r"-?[\d.]+", path.attrib["d"]), dtype=float).reshape(-1, 2)


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
