"""Sign constraints: σ f ≥ τ at given places, with σ the side (1 outside, −1 inside) and τ ≥ 0 a margin.

A place where σ f falls short of τ by v = max(0, τ − σf) costs weight · v². The places with v > 0 are the active ones.
Over them, with P the row of basis values, run the sums that a constraint set adds to the normal equations: the matrix
Σ weight · PᵀP and the right-hand side Σ weight · σ v P. Both come from moments.
"""

from copy import copy
from typing import Protocol, Self

import numpy as np

from ipcore._typing import FloatArray
from ipcore.geometric.inside_outside import Classification, InsideOutside
from ipcore.polynomial import evaluation, gram, univariate
from ipcore.polynomial.box import Box
from ipcore.polynomial.univariate import Basis

# The nodes lie in the bounds grown by this factor: a branch hidden between the outermost nodes would cut the walls.
BOUNDS_GROWTH = 1.02
# τ = MARGIN_SLOPE · min(distance − blind radius / 2, MARGIN_DISTANCE), in mean radii, so τ ≤ 0.05. Near the data f has
# slope 1, so where the fit is as close as the stopping rule wants, a margin of half the distance costs nothing.
MARGIN_SLOPE = 0.5
MARGIN_DISTANCE = 0.10


class SignConstraints(Protocol):
    """A set of sign constraints, as the objective uses it."""

    def shortfall(self, tensor: FloatArray) -> FloatArray:
        """Return v at every place, in the set's own shape, for the Chebyshev coefficients `tensor` (n+1, …) of f."""
        ...

    def cost(self, shortfall: FloatArray) -> float:
        """Return Σ weight · v²."""
        ...

    def active(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return the moments (C, 1) of the weights of the active places, up to degree 2·`degree`."""
        ...

    def half_descent(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return Σ weight · σ v P, (m,): half the negative gradient of the cost."""
        ...


def margin(located: Classification) -> FloatArray:
    """Return τ (M,) at M classified places."""
    return MARGIN_SLOPE * np.minimum(located.distance - located.blind_radius / 2.0, MARGIN_DISTANCE)


class SignNodes:
    """Sign constraints at all nodes of a Chebyshev–Lobatto grid, the same number along every axis.

    On an evenly spaced grid a polynomial of high degree has room for further branches between the nodes near the walls.
    """

    def __init__(self, located: Classification, count: int, weight: float) -> None:
        """Take the classified nodes (count^d,), in C order, and the weight of them all together."""
        d = round(np.log(len(located.side)) / np.log(count))
        side, away = located.side, located.distance > located.blind_radius
        self.unsure = float((side[away] == 0.0).mean()) if away.any() else 1.0
        self.side = side.reshape((count,) * d)
        self.margin = np.where(side == 0.0, 0.0, margin(located)).reshape((count,) * d)
        self.weight = weight / side.size
        self._lines = lobatto(count)
        self._tables: dict[int, FloatArray] = {}

    @classmethod
    def of(cls, sides: InsideOutside, bounds: FloatArray, count: int, weight: float) -> Self:
        """Classify the nodes, `count` per axis of the bounds (2, d); `weight` is that of all nodes together."""
        box = Box.of(bounds)
        lines = [box.axis_from_cube(lobatto(count), axis) for axis in range(bounds.shape[1])]
        nodes = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        return cls(sides.classify(nodes.reshape(-1, bounds.shape[1])), count, weight)

    def shortfall(self, tensor: FloatArray) -> FloatArray:
        """Return v (count, …) on the grid, for the Chebyshev coefficients `tensor` (n+1, …)."""
        values = evaluation.along_axes(tensor, [self._table(len(tensor) - 1).T] * tensor.ndim)
        values *= self.side
        np.subtract(self.margin, values, out=values)
        return np.maximum(values, 0.0, out=values)

    def heavier(self, factor: float) -> Self:
        """Return the same constraints with `factor` times the weight."""
        heavy = copy(self)
        heavy.weight = factor * self.weight
        return heavy

    def cost(self, shortfall: FloatArray) -> float:
        """Return Σ weight · v²."""
        return self.weight * float(np.vdot(shortfall, shortfall))

    def active(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return the moments (C, 1) of the weights of the active nodes, up to degree 2·`degree`."""
        mask = (shortfall > 0.0).astype(float)
        return self.weight * gram.grid_moments(mask, self._table(2 * degree))

    def half_descent(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return Σ weight · σ v P, (m,)."""
        table = self._table(degree)
        tensor = evaluation.along_axes(shortfall * self.side, [table] * shortfall.ndim)
        return np.asarray(self.weight * evaluation.from_tensor(tensor, shortfall.ndim, degree))

    def _table(self, degree: int) -> FloatArray:
        """Return the Chebyshev polynomials up to this degree at the grid lines, (degree + 1, count)."""
        if degree not in self._tables:
            self._tables[degree] = univariate.table(Basis.CHEBYSHEV, self._lines, degree)
        return self._tables[degree]


class SignPoints:
    """Sign constraints at single places, given in the Chebyshev variables t."""

    def __init__(self, t: FloatArray, side: FloatArray, margin: FloatArray, weight: FloatArray) -> None:
        """Take places (M, d), and σ, τ and weights (M,) each."""
        self.t, self.side, self.margin, self.weight = t, side, margin, weight
        self._tables: dict[int, list[FloatArray]] = {}

    def with_more(self, more: "SignPoints") -> "SignPoints":
        """Return these constraints followed by others."""
        return SignPoints(
            np.concatenate([self.t, more.t]),
            np.concatenate([self.side, more.side]),
            np.concatenate([self.margin, more.margin]),
            np.concatenate([self.weight, more.weight]),
        )

    def reweighted(self, shortfall: FloatArray, factor: float) -> "SignPoints":
        """Return the same constraints, with `factor` times the weight where f has the wrong sign (v > τ)."""
        wrong = shortfall > self.margin
        return SignPoints(self.t, self.side, self.margin, np.where(wrong, factor * self.weight, self.weight))

    def cost(self, shortfall: FloatArray) -> float:
        """Return Σ weight · v²."""
        return float(self.weight @ shortfall**2)

    def shortfall(self, tensor: FloatArray) -> FloatArray:
        """Return v (M,), for the Chebyshev coefficients `tensor` (n+1, …)."""
        f = evaluation.scattered(tensor[None], self._at(len(tensor) - 1))[0]
        return np.asarray(np.maximum(self.margin - self.side * f, 0.0))

    def active(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return the moments (C, 1) of the weights of the active places, up to degree 2·`degree`."""
        return gram.moments(self._at(2 * degree), np.where(shortfall > 0.0, self.weight, 0.0)[None])

    def half_descent(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return Σ weight · σ v P, (m,)."""
        mu = gram.moments(self._at(degree), (self.weight * self.side * shortfall)[None])
        return np.asarray(gram.in_graded_order(mu, self.t.shape[1], degree)[:, 0])

    def _at(self, degree: int) -> list[FloatArray]:
        """Return the Chebyshev polynomials up to this degree at the places, (degree + 1, M) for each axis."""
        if degree not in self._tables:
            self._tables[degree] = [
                univariate.table(Basis.CHEBYSHEV, np.ascontiguousarray(row), degree) for row in self.t.T
            ]
        return self._tables[degree]


def lobatto(count: int) -> FloatArray:
    """Return `count` Chebyshev–Lobatto nodes from −BOUNDS_GROWTH to BOUNDS_GROWTH.

    >>> lobatto(3).round(2).tolist()
    [-1.02, -0.0, 1.02]
    """
    return -BOUNDS_GROWTH * np.cos(np.pi * np.arange(count) / (count - 1))
