"""Shapes as people's files have them: curves that touch or cross themselves, thin ones, ones with few points."""

from collections.abc import Callable

import numpy as np

from ipcore._typing import FloatArray


def ring(count: int, centre: tuple[float, float] = (0.0, 0.0), radius: float = 1.0) -> FloatArray:
    turn = 2.0 * np.pi * np.arange(count) / count
    return np.asarray(centre) + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def turned(points: FloatArray, angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def polygon(corners: list[tuple[float, float]], count: int) -> FloatArray:
    """Return points in equal steps along a closed polygon."""
    p = np.array([*corners, corners[0]], dtype=np.float64)
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1)))
    at = np.linspace(0.0, along[-1], count, endpoint=False)
    return np.column_stack([np.interp(at, along, x) for x in p.T])


def touching_discs(count: int, ratio: float) -> FloatArray:
    return np.vstack([ring(count), ring(max(6, int(ratio * count)), (1.0 + ratio, 0.0), ratio)])


def disc_in_disc(count: int, ratio: float) -> FloatArray:
    return np.vstack([ring(count), ring(max(6, int(ratio * count)), (1.0 - ratio, 0.0), ratio)])


def three_discs(count: int, ratio: float) -> FloatArray:
    third = (1.0, np.sqrt((1.0 + ratio) ** 2 - 1.0))
    return np.vstack([ring(count), ring(count, (2.0, 0.0)), ring(count, third, ratio)])


def lemniscate(count: int, ratio: float) -> FloatArray:
    turn = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(turn), ratio * np.sin(turn) * np.cos(turn)]) / (1.0 + np.sin(turn[:, None]) ** 2)


def bow_tie(count: int, ratio: float) -> FloatArray:
    return polygon([(-1.0, -ratio), (1.0, ratio), (1.0, -ratio), (-1.0, ratio)], count)


def hourglass(count: int, ratio: float) -> FloatArray:
    return polygon([(-1.0, -ratio), (0.0, 0.0), (-1.0, ratio), (1.0, ratio), (0.0, 0.0), (1.0, -ratio)], count)


def plus(count: int, ratio: float) -> FloatArray:
    """Return a cross of lines that are run along both ways: it has no inside."""
    o = (0.0, 0.0)
    return polygon([(-1.0, 0.0), o, (0.0, ratio), o, (1.0, 0.0), o, (0.0, -ratio), o], count)


def notch(count: int, ratio: float) -> FloatArray:
    """Return a square with a slit without width."""
    corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0), (0.0, 1.0 - 2.0 * ratio), (0.0, 1.0), (-1.0, 1.0)]
    return polygon(corners, count)


def needle(count: int, ratio: float) -> FloatArray:
    return ring(count) * [1.0, ratio]


def annulus(count: int, ratio: float) -> FloatArray:
    return np.vstack([ring(count), ring(max(6, int(ratio * count)), radius=ratio)])


def line_and_point(count: int, ratio: float) -> FloatArray:
    return np.column_stack([np.append(np.linspace(-1.0, 1.0, count - 1), 0.0), np.append(np.zeros(count - 1), ratio)])


CURVES: dict[str, Callable[[int, float], FloatArray]] = {
    made.__name__: made
    for made in (
        touching_discs, disc_in_disc, three_discs, lemniscate, bow_tie, hourglass, plus, notch, needle, annulus,
        line_and_point,
    )
}  # fmt: skip


def ellipsoid(count: int, axes: tuple[float, float, float], seed: int | None = None) -> tuple[FloatArray, FloatArray]:
    """Return points and normals of an ellipsoid, turned at random if there is a seed."""
    i = np.arange(count)
    height, turn = 1.0 - (2.0 * i + 1.0) / count, np.pi * (1.0 + np.sqrt(5.0)) * i
    radius = np.sqrt(1.0 - height**2)
    u = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
    points, normals = u * axes, u / axes
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    Q = np.eye(3) if seed is None else np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return points @ Q, normals @ Q
