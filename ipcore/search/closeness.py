r"""How close and how smooth a polynomial is at the data (the paper's section 4.2).

D_dist   = mean |f(x_i)| / ‖∇f(x_i)‖         the first-order distance of the data from the zero set, in mean radii
D_smooth = mean n_i · ∇f(x_i) / ‖∇f(x_i)‖    the cosine between the data's normals and the fit's               (6)

Where f and ∇f vanish together, ‖∇f‖ is replaced by a small share of its maximum (`SHORTEST_GRADIENT`).
All polynomials and points here are in the normalised frame. The data are taken part by part, by several threads.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ipcore import _threads
from ipcore._typing import FloatArray
from ipcore.points.oriented import OrientedPoints, Part
from ipcore.polynomial.implicit import ImplicitPolynomial, values_and_gradients
from ipcore.search.stopping_rule import SHORTEST_GRADIENT

WeightedPart = tuple[Part, FloatArray | None]


@dataclass(frozen=True, eq=False)
class Closeness:
    """How close a fit is to its data.

    Attributes
    ----------
    d_dist, d_smooth
        The two means above.
    max_distance
        The maximum of |f|/‖∇f‖ over the data, in mean radii.

    """

    d_dist: float
    d_smooth: float
    max_distance: float


def distances_and_cosines(f: FloatArray, gradient: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return |f|/‖∇f‖ and n·∇f/‖∇f‖, (N,) each, from f (N,) and ∇f (N, d) in the normalised frame and unit normals.

    >>> at = distances_and_cosines(np.array([0.1]), np.array([[0.0, 2.0]]), np.array([[0.0, 1.0]]))
    >>> [values.tolist() for values in at]
    [[0.05], [1.0]]
    """
    size = _lengths(gradient)
    return np.abs(f) / size, np.einsum("ij,ij->i", normals, gradient) / size


def closenesses(
    polynomials: Sequence[ImplicitPolynomial], data: OrientedPoints, weights: FloatArray | None = None
) -> list[Closeness]:
    """Return how close each of p polynomials, all in one basis, is to the data, in one pass over all points.

    With weights (N,), one for each point that is held, the means are weighted, and the points of a stream that are not
    held do not count.
    """
    sums, maxima = np.zeros((2, len(polynomials))), np.zeros(len(polynomials))
    for part_sums, part_maxima in _threads.ordered(partial(_sums, polynomials), _weighted_parts(data, weights)):
        sums += part_sums
        maxima = np.maximum(maxima, part_maxima)
    d_dist, d_smooth = sums / (data.count if weights is None else weights.sum())
    return [Closeness(*three) for three in zip(d_dist.tolist(), d_smooth.tolist(), maxima.tolist(), strict=True)]


def closeness(polynomial: ImplicitPolynomial, data: OrientedPoints, weights: FloatArray | None = None) -> Closeness:
    """Return how close one polynomial is to the data, as `closenesses` does."""
    return closenesses([polynomial], data, weights)[0]


def distance_quantile(polynomial: ImplicitPolynomial, data: OrientedPoints, share: float) -> float:
    """Return the quantile `share`, 0 … 1, of the distances |f|/‖∇f‖, in mean radii.

    Of many points, a sample is taken.
    """
    parts = _threads.ordered(partial(_distances_and_cosines, [polynomial]), data.thinned.parts())
    return float(np.quantile(np.concatenate([distances for ((distances, _),) in parts]), share))


def delivery_shift(fitted: ImplicitPolynomial, delivered: ImplicitPolynomial, data: OrientedPoints) -> float:
    """Return the maximum over the data of |f_fitted − f_delivered| / ‖∇f_delivered‖, in mean radii.

    To first order, it is how far the zero set moves at the data when the coefficients are converted to another basis.
    """
    if delivered.basis is fitted.basis:
        return 0.0
    return max(_threads.ordered(partial(_shift, fitted, delivered), data.parts()))


def _weighted_parts(data: OrientedPoints, weights: FloatArray | None) -> Iterable[WeightedPart]:
    """Return the parts of the data with the weights (n,) of their points, or None in place of weights."""
    if weights is None and data.stream is not None:
        return ((part, None) for part in data.parts())
    parts = data.held_parts()
    ends = np.cumsum([len(part.points) for part in parts])[:-1]
    each = [None] * len(parts) if weights is None else np.split(weights, ends)
    return list(zip(parts, each, strict=True))


def _sums(polynomials: Sequence[ImplicitPolynomial], weighted: WeightedPart) -> tuple[FloatArray, FloatArray]:
    """Return Σ w |f|/‖∇f‖ and Σ w n·∇f/‖∇f‖, (2, p), and the largest |f|/‖∇f‖, (p,), over one part."""
    part, w = weighted
    values = np.array(_distances_and_cosines(polynomials, part))  # (p, 2, n)
    return (values.sum(axis=2) if w is None else values @ w).T, values[:, 0].max(axis=1)


def _distances_and_cosines(
    polynomials: Sequence[ImplicitPolynomial], part: Part
) -> list[tuple[FloatArray, FloatArray]]:
    """Return |f|/‖∇f‖ and n·∇f/‖∇f‖, (n,) each, of every polynomial at one part."""
    n = part.normals
    return [distances_and_cosines(f, gradient, n) for f, gradient in values_and_gradients(polynomials, part.points)]


def _shift(fitted: ImplicitPolynomial, delivered: ImplicitPolynomial, part: Part) -> float:
    """Return the maximum of |f_fitted − f_delivered| / ‖∇f_delivered‖ over one part."""
    f, gradient = delivered.value_and_gradient(part.points)
    return float((np.abs(fitted(part.points) - f) / _lengths(gradient)).max())


def _lengths(gradient: FloatArray) -> FloatArray:
    """Return ‖∇f‖ (n,) of gradients (n, d), none shorter than `SHORTEST_GRADIENT` times the longest."""
    length = np.linalg.norm(gradient, axis=1)
    return np.asarray(np.maximum(length, max(SHORTEST_GRADIENT * length.max(initial=0.0), np.finfo(float).tiny)))
