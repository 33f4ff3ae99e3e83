"""Sign constraints: σ f ≥ τ at given places, σ the side (1 outside, −1 inside) and τ a margin that grows with distance.

A place that falls short by v = max(0, τ − σf) costs weight · v². Those that do are the active ones; their part of the
normal equations is weight · Σ PᵀP over them, P the row of basis values, and weight · Σ σ v P, both from moments.
"""

from copy import copy
from typing import Protocol

import numpy as np

from ipcore._typing import FloatArray
from ipcore.geometric.inside_outside import Classification, InsideOutside
from ipcore.polynomial import evaluation, gram, univariate
from ipcore.polynomial.univariate import Basis

# Nodes lie in the box grown by this factor: what hides between the outermost nodes would cut the box's walls.
BEYOND = 1.02
# The margin is this share of the distance beyond half of what is near, and at most that of 0.1 mean radii: τ ≤ 0.05.
# f has slope 1 about, so where the fit is as close as asked, a margin of half the distance costs nothing.
SLOPE = 0.5
FARTHEST = 0.10


class SignConstraints(Protocol):
    """Places where f has a sign to have."""

    def shortfall(self, tensor: FloatArray) -> FloatArray:
        """Return v, any shape, for the polynomial with these Chebyshev coefficients (n+1, …)."""
        ...

    def cost(self, shortfall: FloatArray) -> float:
        """Return Σ weight · v²."""
        ...

    def active(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return the moments (C, 1) of weight over the active places, up to 2·degree."""
        ...

    def half_descent(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return weight · Σ σ v P, (m,): half the cost's negative gradient."""
        ...


def margin(located: Classification) -> FloatArray:
    """Return τ at places."""
    return SLOPE * np.minimum(located.distance - located.near / 2.0, FARTHEST)


class SignNodes:
    """All nodes of a Chebyshev–Lobatto grid: on an even grid sheets slip between the nodes near the walls."""

    def __init__(self, located: Classification, count: int, weight: float) -> None:
        """Take what is known of the nodes (count^d,), in C order, and the weight of them all together."""
        d = round(np.log(len(located.side)) / np.log(count))
        side, away = located.side, located.distance > located.near
        self.unsure = float((side[away] == 0.0).mean()) if away.any() else 1.0
        self.side = side.reshape((count,) * d)
        self.margin = np.where(side == 0.0, 0.0, margin(located)).reshape((count,) * d)
        self.weight = weight / side.size
        self._lines = lobatto(count)
        self._tables: dict[int, FloatArray] = {}

    @classmethod
    def of(cls, sides: InsideOutside, bounds: FloatArray, count: int, weight: float) -> "SignNodes":
        """Ask for the sides that are sure, on `count` nodes per axis of the bounds (2, d)."""
        middle, half = bounds.mean(axis=0), (bounds[1] - bounds[0]) / 2.0
        lines = [m + h * lobatto(count) for m, h in zip(middle, half, strict=True)]
        nodes = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        return cls(sides.at(nodes.reshape(-1, len(half))), count, weight)

    def shortfall(self, tensor: FloatArray) -> FloatArray:
        """Return v on the grid."""
        values = evaluation.along_axes(tensor, [self._table(len(tensor) - 1).T] * tensor.ndim)
        values *= self.side
        np.subtract(self.margin, values, out=values)
        return np.maximum(values, 0.0, out=values)

    def heavier(self, factor: float) -> "SignNodes":
        """Return the same nodes with more weight."""
        heavy = copy(self)
        heavy.weight = factor * self.weight
        return heavy

    def cost(self, shortfall: FloatArray) -> float:
        """Return Σ weight · v²."""
        return self.weight * float(np.vdot(shortfall, shortfall))

    def active(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return the moments (C, 1) of weight over the active nodes, up to 2·degree."""
        mask = (shortfall > 0.0).astype(float)
        return self.weight * gram.grid_moments(mask, self._table(2 * degree))

    def half_descent(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return weight · Σ σ v P, (m,)."""
        table = self._table(degree)
        tensor = evaluation.along_axes(shortfall * self.side, [table] * shortfall.ndim)
        return np.asarray(self.weight * evaluation.from_tensor(tensor, shortfall.ndim, degree))

    def _table(self, degree: int) -> FloatArray:
        if degree not in self._tables:
            self._tables[degree] = univariate.table(Basis.CHEBYSHEV, self._lines, degree)
        return self._tables[degree]


class SignPoints:
    """Single places, in the Chebyshev variables t."""

    def __init__(self, t: FloatArray, side: FloatArray, margin: FloatArray, weight: FloatArray) -> None:
        """Take places (M, d), σ, τ and weights (M,)."""
        self.t, self.side, self.margin, self.weight = t, side, margin, weight
        self._tables: dict[int, list[FloatArray]] = {}

    def with_more(self, more: "SignPoints") -> "SignPoints":
        """Return these and more."""
        return SignPoints(
            np.concatenate([self.t, more.t]),
            np.concatenate([self.side, more.side]),
            np.concatenate([self.margin, more.margin]),
            np.concatenate([self.weight, more.weight]),
        )

    def reweighted(self, shortfall: FloatArray, factor: float) -> "SignPoints":
        """Return the same places, those where f has the wrong sign with more weight."""
        wrong = shortfall > self.margin
        return SignPoints(self.t, self.side, self.margin, np.where(wrong, factor * self.weight, self.weight))

    def cost(self, shortfall: FloatArray) -> float:
        """Return Σ weight · v²."""
        return float(self.weight @ shortfall**2)

    def shortfall(self, tensor: FloatArray) -> FloatArray:
        """Return v (M,)."""
        f = evaluation.scattered(tensor[None], self._at(len(tensor) - 1))[0]
        return np.asarray(np.maximum(self.margin - self.side * f, 0.0))

    def active(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return the moments (C, 1) of weight over the active places, up to 2·degree."""
        return gram.moments(self._at(2 * degree), np.where(shortfall > 0.0, self.weight, 0.0)[None])

    def half_descent(self, shortfall: FloatArray, degree: int) -> FloatArray:
        """Return weight · Σ σ v P, (m,)."""
        mu = gram.moments(self._at(degree), (self.weight * self.side * shortfall)[None])
        return np.asarray(gram.in_graded_order(mu, self.t.shape[1], degree)[:, 0])

    def _at(self, degree: int) -> list[FloatArray]:
        if degree not in self._tables:
            self._tables[degree] = [
                univariate.table(Basis.CHEBYSHEV, np.ascontiguousarray(row), degree) for row in self.t.T
            ]
        return self._tables[degree]


def lobatto(count: int) -> FloatArray:
    """Return `count` Chebyshev–Lobatto nodes, −BEYOND … BEYOND.

    >>> lobatto(3).round(2).tolist()
    [-1.02, -0.0, 1.02]
    """
    return -BEYOND * np.cos(np.pi * np.arange(count) / (count - 1))
