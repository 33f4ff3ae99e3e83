"""A polynomial seen from all of its data, part by part."""

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from ipcore import _threads
from ipcore._typing import FloatArray
from ipcore.points.oriented import OrientedPoints, Part
from ipcore.polynomial.implicit import ImplicitPolynomial, values_and_gradients
from ipcore.search.criteria import Closeness, distances_and_cosines

Weighed = tuple[Part, FloatArray | None]


def closenesses(
    polynomials: Sequence[ImplicitPolynomial], data: OrientedPoints, weights: FloatArray | None = None
) -> list[Closeness]:
    """Return how close polynomials of the normalised frame, all in one basis, are to their data, in one pass.

    If there are weights, one for each point that is held, these points count and no others.
    """
    sums, farthest = np.zeros((2, len(polynomials))), np.zeros(len(polynomials))
    for some, far in _threads.ordered(partial(_sums, polynomials), _weighed(data, weights)):
        sums += some
        farthest = np.maximum(farthest, far)
    d_dist, d_smooth = sums / (data.count if weights is None else weights.sum())
    return [Closeness(*three) for three in zip(d_dist.tolist(), d_smooth.tolist(), farthest.tolist(), strict=True)]


def closeness(polynomial: ImplicitPolynomial, data: OrientedPoints, weights: FloatArray | None = None) -> Closeness:
    """Return how close a polynomial of the normalised frame is to its data, as `closenesses` does."""
    return closenesses([polynomial], data, weights)[0]


def percentile(polynomial: ImplicitPolynomial, data: OrientedPoints, share: float) -> float:
    """Return the distance |f|/‖∇f‖, in mean radii, within which this share of the points lies; of many, a sample."""
    seen = _threads.ordered(partial(_seen, [polynomial]), data.thinned.parts())
    return float(np.quantile(np.concatenate([distances for ((distances, _),) in seen]), share))


def moved(fitted: ImplicitPolynomial, delivered: ImplicitPolynomial, data: OrientedPoints) -> float:
    """Return how far the delivered zero set lies from the fitted one at the data, at most, in mean radii."""
    if delivered.basis is fitted.basis:
        return 0.0
    return max(_threads.ordered(partial(_moved, fitted, delivered), data.parts()))


def _weighed(data: OrientedPoints, weights: FloatArray | None) -> Iterable[Weighed]:
    """Return the parts with the weights of their points."""
    if weights is None and data.stream is not None:
        return ((part, None) for part in data.parts())
    parts = data.held_parts()
    ends = np.cumsum([len(part.points) for part in parts])[:-1]
    each = [None] * len(parts) if weights is None else np.split(weights, ends)
    return list(zip(parts, each, strict=True))


def _sums(polynomials: Sequence[ImplicitPolynomial], weighed: Weighed) -> tuple[FloatArray, FloatArray]:
    """Return Σ w |f|/‖∇f‖ and Σ w n·∇f/‖∇f‖, (2, p), and the largest |f|/‖∇f‖ (p,)."""
    part, w = weighed
    seen = np.array(_seen(polynomials, part))  # (p, 2, n)
    return (seen.sum(axis=2) if w is None else seen @ w).T, seen[:, 0].max(axis=1)


def _seen(polynomials: Sequence[ImplicitPolynomial], part: Part) -> list[tuple[FloatArray, FloatArray]]:
    n = part.normals
    return [distances_and_cosines(f, gradient, n) for f, gradient in values_and_gradients(polynomials, part.points)]


def _moved(fitted: ImplicitPolynomial, delivered: ImplicitPolynomial, part: Part) -> float:
    f, gradient = delivered.value_and_gradient(part.points)
    size = np.maximum(np.linalg.norm(gradient, axis=1), np.finfo(float).tiny)
    return float((np.abs(fitted(part.points) - f) / size).max())
