"""Ellipses and ellipsoids of any proportions, turned, with their exact content; samples and zero sets of shapes."""

import numpy as np
from scipy.spatial.transform import Rotation

from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.zero_set import ZeroSet

PAD = 0.3  # mean radii by which the bounds are larger than the shape, as those of a fit


def turn(dimension: int, seed: int | None) -> FloatArray:
    """Return a random rotation (d, d), or none."""
    if seed is None:
        return np.eye(dimension)
    if dimension == 3:
        return np.asarray(Rotation.random(random_state=seed).as_matrix())
    return turn_by(np.random.default_rng(seed).uniform(0.0, np.pi))


def turn_by(angle: float) -> FloatArray:
    """Return the rotation (2, 2) by an angle."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def quadric(axes: tuple[float, ...], seed: int | None = None) -> tuple[ImplicitPolynomial, FloatArray]:
    """Return the quadric with these half axes, turned at random or not, f(0) = −1, and 2,000 points on its zero set."""
    return turned(axes, turn(len(axes), seed))


def turned(axes: tuple[float, ...], R: FloatArray) -> tuple[ImplicitPolynomial, FloatArray]:
    """Return the same with the rotation R (d, d)."""
    d, half = len(axes), np.array(axes)
    u = np.random.default_rng(0).normal(size=(2000, d))
    points = (u / np.linalg.norm(u, axis=1, keepdims=True) * half) @ R.T
    scale = float(np.linalg.norm(points, axis=1).mean())
    A = R @ np.diag((scale / half) ** 2) @ R.T
    powers = graded.exponents(d, 2)
    a = np.zeros(len(powers))
    a[0] = -1.0
    for k in np.flatnonzero(powers.sum(axis=1) == 2):
        i, j = np.repeat(np.arange(d), powers[k])
        a[k] = A[i, j] * (1.0 if i == j else 2.0)
    reach = np.sqrt(((R * half) ** 2).sum(axis=1)) + PAD * scale
    return ImplicitPolynomial(2, a, Frame(np.zeros(d), scale), np.stack([-reach, reach])), points


def exact_content(axes: tuple[float, ...]) -> float:
    """Return the area of an ellipse, or the volume of an ellipsoid."""
    return float(np.prod(axes)) * (np.pi if len(axes) == 2 else 4.0 / 3.0 * np.pi)


def content(z: ZeroSet) -> float:
    """Return the area or the volume that a zero set encloses."""
    middle = z.vertices[z.cells].mean(axis=1)
    return float(np.einsum("ck,ck->", middle, z.cell_normals())) / z.dimension


def random_sample(z: ZeroSet, count: int, seed: int) -> FloatArray:
    """Return random points (count, d) on the cells of a zero set, evenly spread over its length or area."""
    rng = np.random.default_rng(seed)
    size = np.linalg.norm(z.cell_normals(), axis=1)
    chosen = rng.choice(len(size), count, p=size / size.sum())
    share = rng.dirichlet(np.ones(z.dimension), count)
    return np.asarray(np.einsum("nk,nkd->nd", share, z.vertices[z.cells[chosen]]))
