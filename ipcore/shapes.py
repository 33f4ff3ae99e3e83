"""Algebraic curves and surfaces with known coefficients, for tests, examples and benchmarks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial

Terms = Mapping[tuple[int, ...], float]


@dataclass(frozen=True, eq=False)
class Shape:
    """A compact smooth component of an algebraic zero set, negative inside.

    Attributes
    ----------
    name
        Its name in the literature.
    polynomial
        With frame centre 0 and scale 1, so that its coefficients are those of the equation in x, y, z.
    euler
        Euler characteristic of the zero set within the bounds: 0 for a closed curve, 2 − 2·genus for a surface.

    """

    name: str
    polynomial: ImplicitPolynomial
    euler: int

    def sample(self, count: int, seed: int = 0) -> tuple[FloatArray, FloatArray]:
        """Return N = `count` points on the shape and their unit outward normals, (N, d) each, evenly spread by area.

        Uniformly random points of a thin shell around the zero set are moved onto it by Newton steps
        v ← v − f∇f/‖∇f‖². The same seed gives the same points.

        >>> points, normals = circle().sample(50)
        >>> bool(np.allclose(np.hypot(*points.T), 1.0, atol=1e-14)), normals.shape
        (True, (50, 2))
        """
        generator, found, total = np.random.default_rng(seed), [], 0
        lower, upper = self.polynomial.bounds
        thickness = 0.02 * float((upper - lower).max())
        while total < count:
            x = generator.uniform(lower, upper, (50 * count, len(lower)))
            x = _onto(self.polynomial, x[np.abs(self.polynomial.distance(x)) < thickness])
            found.append(x[self.polynomial.contains(x)])
            total += len(found[-1])
        points = np.concatenate(found)[:count]
        gradient = self.polynomial.gradient(points)
        return points, gradient / np.linalg.norm(gradient, axis=1, keepdims=True)


def _onto(polynomial: ImplicitPolynomial, x: FloatArray) -> FloatArray:
    """Return points x (N, d), near the zero set, moved onto it."""
    for _ in range(8):  # quadratic convergence from a shell 2 % thick: rounding is reached in 4 or 5
        f, gradient = polynomial.value_and_gradient(x)
        x = x - (f / (gradient**2).sum(axis=1))[:, None] * gradient
    return x


def _shape(name: str, terms: Terms, half: tuple[float, ...], euler: int, middle: tuple[float, ...] = ()) -> Shape:
    """Return the shape with these terms, exponents to coefficient, in a box of half-widths (d,) around its middle."""
    d, degree = len(half), max(sum(powers) for powers in terms)
    a = np.zeros(graded.count(d, degree))
    a[graded.column(np.array(list(terms)))] = list(terms.values())
    centre = np.array(middle or (0.0,) * d)
    bounds = np.stack([centre - half, centre + half])
    return Shape(name, ImplicitPolynomial(degree, a, Frame(np.zeros(d), 1.0), bounds), euler)


def circle() -> Shape:
    """Return x² + y² = 1."""
    return _shape("circle", {(0, 0): -1, (2, 0): 1, (0, 2): 1}, (1.4, 1.4), 0)


def ellipse(a: float = 2.0, b: float = 1.0) -> Shape:
    """Return (x/a)² + (y/b)² = 1."""
    return _shape(f"ellipse {a:g}:{b:g}", {(0, 0): -1, (2, 0): a**-2, (0, 2): b**-2}, (a + 0.4, b + 0.4), 0)


def cubic() -> Shape:
    """Return the oval of the elliptic curve y² = x³ − x, in −1 ≤ x ≤ 0; its other branch is outside the bounds."""
    return _shape("cubic", {(0, 2): 1, (3, 0): -1, (1, 0): 1}, (0.75, 0.9), 0, (-0.5, 0.0))


def superellipse() -> Shape:
    """Return x⁴ + y⁴ = 1."""
    return _shape("superellipse", {(0, 0): -1, (4, 0): 1, (0, 4): 1}, (1.4, 1.4), 0)


def sphere() -> Shape:
    """Return x² + y² + z² = 1."""
    return _shape("sphere", {(0, 0, 0): -1, (2, 0, 0): 1, (0, 2, 0): 1, (0, 0, 2): 1}, (1.4,) * 3, 2)


def ellipsoid(a: float = 2.0, b: float = 1.5, c: float = 1.0) -> Shape:
    """Return (x/a)² + (y/b)² + (z/c)² = 1."""
    terms: Terms = {(0, 0, 0): -1.0, (2, 0, 0): a**-2, (0, 2, 0): b**-2, (0, 0, 2): c**-2}
    return _shape("ellipsoid", terms, (a + 0.4, b + 0.4, c + 0.4), 2)


def torus(major: float = 1.0, minor: float = 0.4) -> Shape:
    """Return (x² + y² + z² + R² − r²)² = 4R²(x² + y²), with R = `major` and r = `minor`."""
    shift = major**2 - minor**2
    terms = _squared_radius_squared(2.0 * shift) | {(0, 0, 0): shift**2}
    terms[2, 0, 0] -= 4.0 * major**2
    terms[0, 2, 0] -= 4.0 * major**2
    wide = major + minor + 0.3
    return _shape("torus", terms, (wide, wide, minor + 0.3), 0)


def genus_two() -> Shape:
    """Return a quartic of genus 2: a hollow sphere with three holes, (r² − 1)(r² − ¼) + 0.4 (x³ − 3xy²) = 0."""
    terms = _squared_radius_squared(-1.25) | {(0, 0, 0): 0.25, (3, 0, 0): 0.4, (1, 2, 0): -1.2}
    return _shape("genus-2 quartic", terms, (1.5,) * 3, -2)


def superellipsoid() -> Shape:
    """Return the sextic x⁶ + y⁶ + z⁶ = 1."""
    return _shape("superellipsoid", {(0, 0, 0): -1, (6, 0, 0): 1, (0, 6, 0): 1, (0, 0, 6): 1}, (1.4,) * 3, 2)


def _squared_radius_squared(middle: float) -> dict[tuple[int, ...], float]:
    """Return the terms of r⁴ + middle·r², r² = x² + y² + z²."""
    terms: dict[tuple[int, ...], float] = {}
    for axis in range(3):
        unit = tuple(int(k == axis) for k in range(3))
        terms[tuple(2 * p for p in unit)] = middle
        terms[tuple(4 * p for p in unit)] = 1.0
        terms[tuple(2 - 2 * p for p in unit)] = 2.0
    return terms


CURVES = (circle, ellipse, cubic, superellipse)
SURFACES = (sphere, ellipsoid, torus, genus_two, superellipsoid)
