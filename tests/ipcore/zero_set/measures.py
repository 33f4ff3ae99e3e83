"""Polynomials of known shapes, and measures of zero sets that are known of them."""

from itertools import pairwise

import numpy as np

from ipcore import shapes
from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.zero_set import ZeroSet

EPS = float(np.finfo(float).eps)

SQUARE = np.array([[-2.0, -2.0], [2.0, 2.0]])

CUBE = np.array([[-1.5] * 3, [1.5] * 3])

SPHERE, TORUS, CIRCLE = shapes.sphere().polynomial, shapes.torus(1.0, 0.4).polynomial, shapes.circle().polynomial


def polynomial(terms: dict[tuple[int, ...], float], bounds: FloatArray) -> ImplicitPolynomial:
    degree, d = max(map(sum, terms)), bounds.shape[1]
    a = np.zeros(graded.count(d, degree))
    a[graded.column(np.array(list(terms)))] = list(terms.values())
    return ImplicitPolynomial(degree, a, Frame(np.zeros(d), 1.0), bounds)


def product(p: ImplicitPolynomial, q: ImplicitPolynomial, bounds: FloatArray) -> ImplicitPolynomial:
    terms: dict[tuple[int, ...], float] = {}
    for a, u in zip(p.coefficients, p.exponents, strict=True):
        for b, v in zip(q.coefficients, q.exponents, strict=True):
            key = tuple((u + v).tolist())
            terms[key] = terms.get(key, 0.0) + float(a * b)
    return polynomial(terms, bounds)


def moved(p: ImplicitPolynomial, shift: float, scale: float) -> ImplicitPolynomial:
    """Return p after x → scale · x + shift."""
    return ImplicitPolynomial(
        p.degree, p.coefficients, Frame(p.frame.centre * scale + shift, scale), p.bounds * scale + shift
    )


def size(z: ZeroSet) -> float:
    return float(np.linalg.norm(z.cell_normals(), axis=1).sum())


def content(z: ZeroSet) -> float:
    """Return the area or volume within, by the divergence theorem: negative if cells face inward."""
    middle = z.vertices[z.cells].mean(axis=1)
    return float((middle * z.cell_normals()).sum()) / z.dimension


def directed_edges(cells: IntArray) -> list[tuple[int, int]]:
    return [(int(a), int(b)) for k in range(3) for a, b in zip(cells[:, k], cells[:, (k + 1) % 3], strict=True)]


def euler(z: ZeroSet) -> int:
    edges = {frozenset(edge) for edge in directed_edges(z.cells)}
    return len(z.vertices) - len(edges) + len(z.cells)


def watertight(z: ZeroSet) -> bool:
    """Return whether every edge is used once in either direction, or every vertex of a curve entered and left once."""
    if z.dimension == 2:
        return bool((np.sort(z.cells[:, 0]) == np.sort(z.cells[:, 1])).all())
    edges = directed_edges(z.cells)
    return len(set(edges)) == len(edges) and {(b, a) for a, b in edges} == set(edges)


def on_wall(z: ZeroSet, bounds: FloatArray) -> BoolArray:
    """Return which cells lie on a wall of the box."""
    corners = z.vertices[z.cells]
    walls = [(corners[:, :, axis] == side[axis]).all(axis=1) for axis in range(z.dimension) for side in bounds]
    return np.asarray(np.any(walls, axis=0))


def ring(count: int, start: float = 0.0, stop: float = 2.0 * np.pi) -> FloatArray:
    t = np.linspace(start, stop, count, endpoint=False)
    return np.stack([np.cos(t), np.sin(t)], axis=1)


def rates(errors: list[float]) -> list[float]:
    return [float(np.log2(coarse / fine)) for coarse, fine in pairwise(errors)]
