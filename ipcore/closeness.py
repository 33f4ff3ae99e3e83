"""A polynomial seen from all of its data, part by part."""

from functools import partial

import numpy as np

from ipcore import parallel
from ipcore._typing import FloatArray
from ipcore.criteria import Closeness, distances_and_cosines
from ipcore.oriented import OrientedPoints, Part
from ipcore.polynomial import ImplicitPolynomial

Seen = tuple[FloatArray, FloatArray]


def closeness(polynomial: ImplicitPolynomial, data: OrientedPoints, weights: FloatArray | None = None) -> Closeness:
    """Return how close a polynomial of the normalised frame is to its data.

    Of a stream, the means and the maximum are over all points, the percentile is that of the sample that is held; and
    if there are weights, for each point that is held, everything is of the sample.
    """
    look = partial(_seen, polynomial)
    if data.stream is None or weights is not None:
        held = data if data.stream is None else data.thinned
        distances, cosines = (np.concatenate(c) for c in zip(*parallel.ordered(look, held.parts()), strict=True))
        return Closeness.of(distances, cosines, weights)
    sums, farthest = np.zeros(2), 0.0
    for distances, cosines in parallel.ordered(look, data.parts()):
        sums += distances.sum(), cosines.sum()
        farthest = max(farthest, float(distances.max()))
    d_dist, d_smooth = (sums / data.count).tolist()
    return Closeness(d_dist, d_smooth, farthest, closeness(polynomial, data.thinned).distances)


def moved(fitted: ImplicitPolynomial, delivered: ImplicitPolynomial, data: OrientedPoints) -> float:
    """Return how far the delivered zero set lies from the fitted one at the data, at most, in mean radii."""
    if delivered.basis is fitted.basis:
        return 0.0
    return max(parallel.ordered(partial(_moved, fitted, delivered), data.parts()))


def _seen(polynomial: ImplicitPolynomial, part: Part) -> Seen:
    return distances_and_cosines(*polynomial.value_and_gradient(part.points), part.normals)


def _moved(fitted: ImplicitPolynomial, delivered: ImplicitPolynomial, part: Part) -> float:
    f, gradient = delivered.value_and_gradient(part.points)
    size = np.maximum(np.linalg.norm(gradient, axis=1), np.finfo(float).tiny)
    return float((np.abs(fitted(part.points) - f) / size).max())
