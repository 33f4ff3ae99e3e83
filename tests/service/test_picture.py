"""The picture of a fit, read as XML: its card and the charts of its steps say what the fit says."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest

import ipcore
from ipcore import shapes
from service.formats.picture import trace
from service.formats.picture.page import plot
from tests.service.pictures import CIRCLE, NAMESPACE, at, flat, parse, result


def heights(chart: ET.Element, kind: str) -> list[float]:
    return [float(circle.attrib["cy"]) for circle in chart.iterfind(f"svg:circle[@class='{kind}']", NAMESPACE)]


def threshold(chart: ET.Element) -> float:
    line = at(chart, "svg:path[@class='threshold']").attrib["d"]
    return float(line.split()[1].split("H")[0])


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
            assert trace.LEFT < across[0] <= across[-1] < trace.CHART_WIDTH

    def test_distance_is_logarithmic(self) -> None:
        # Axis from 1 to 0.001: three decades.
        chart, decade = at(flat(list(self.STEPS)), ".//svg:g[@id='d_dist']"), trace.CHART_HEIGHT / 3.0
        expected = [-decade * np.log10(d) for d, _ in self.STEPS]
        assert heights(chart, "step") == pytest.approx(expected, abs=0.051)
        assert threshold(chart) == pytest.approx(2.0 * decade, abs=0.051)

    def test_smoothness_is_linear(self) -> None:
        chart = at(flat(list(self.STEPS)), ".//svg:g[@id='d_smooth']")
        expected = [trace.CHART_HEIGHT * (1.0 - s) for _, s in self.STEPS]
        assert heights(chart, "step") == pytest.approx(expected, abs=0.051)
        assert threshold(chart) == pytest.approx(0.05 * trace.CHART_HEIGHT, abs=0.051)

    def test_thresholds_are_those_of_the_options(self) -> None:
        root = flat(list(self.STEPS), ipcore.FitOptions(t1=0.1, t2=0.5))
        assert threshold(at(root, ".//svg:g[@id='d_dist']")) == pytest.approx(trace.CHART_HEIGHT / 3.0, abs=0.051)
        assert threshold(at(root, ".//svg:g[@id='d_smooth']")) == pytest.approx(trace.CHART_HEIGHT / 2.0, abs=0.051)
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
        bottom = trace.CHART_HEIGHT
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
            assert 0.0 <= y <= trace.CHART_HEIGHT
