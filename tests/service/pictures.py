"""Results to draw, and elements of their pictures."""

from xml.etree import ElementTree as ET

import numpy as np

import ipcore
from ipcore import shapes
from service.formats.picture.page import plot

NAMESPACE = {"svg": "http://www.w3.org/2000/svg"}
TURN = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
CIRCLE = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)


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
