r"""The geometric objective: the two measures of the stopping rule as a sum of squares, under sign constraints.

    φ(a) = mean w (f/S)² + λ mean w ‖∇f/S − n‖² + Σ weight · max(0, τ − σf)²,      S = √(t ‖∇f‖² + 1 − t)

The first two terms are means over the data, with the points' weights w. The third is the sum over the sign constraints
(see `sign_constraints`), and it alone fixes the scale of f. At t = 1 the first term is the mean squared first-order
distance and the second 2 − 2 D_smooth, but then φ has many local minima: to turn ∇f back where it points against a
normal, |∇f| would have to pass through 0, where f/S is infinite. At t = 0 there is one minimum only, for φ is convex:
Gradient-One with sign constraints. In between, t is the parameter of a homotopy (see `continuation`).

With ĝ = ∇f/S and P the row of basis values, the row of f/S is (P − t (f/S) ĝ·∇P)/S and those of ĝ are (I − t ĝĝᵀ)∇P/S.
So the Gauss–Newton matrix is Σ D_kᵀ G_kl D_l over k, l = 0…d, with D_0 = I, D_k the differentiation matrices, and G_kl
Gram matrices of P with one weight per point: 6 weighted moment passes in 2D and 10 in 3D, in place of N m² work.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcore._typing import FloatArray
from ipcore.geometric.sign_constraints import SignConstraints
from ipcore.polynomial import evaluation, graded, gram, univariate
from ipcore.polynomial.box import Box
from ipcore.polynomial.univariate import Basis
from ipcore.search.stopping_rule import SHORTEST_GRADIENT

# Up to this many coefficients (2D, degree 15) the product Dᵀ G D is faster with D as a dense matrix.
DENSE_COLUMNS = 150
# S is at least this, while the sign constraints make slopes of about 1: where f is flat, f/S is not undefined, and the
# weights 1/S² of the normal equations do not differ by more than doubles can hold.
FLATTEST = 1e-4


class DataTables:
    """The data in the Chebyshev variables of the bounds, with the Chebyshev polynomials there.

    Attributes
    ----------
    half
        (d,), half of the bounds' length along each axis: d/dx = (d/dt)/half.
    normals
        (d, N), unit, outward.
    weights
        (N,), of sum 1.

    """

    def __init__(self, points: FloatArray, normals: FloatArray, weights: FloatArray, bounds: FloatArray) -> None:
        """Take points and unit normals (N, d), weights (N,) and the bounds (2, d)."""
        box = Box.of(bounds)
        self.half = box.half
        self._t = np.ascontiguousarray(box.to_cube(points).T)
        self._tables: list[FloatArray] = []
        self.normals = np.ascontiguousarray(normals.T)
        self.weights = weights / weights.sum()

    @property
    def dimension(self) -> int:
        """Return d."""
        return len(self._t)

    def tables(self, degree: int) -> list[FloatArray]:
        """Return the Chebyshev polynomials up to this degree at the points, (degree + 1, N) for each axis."""
        if not self._tables or len(self._tables[0]) <= degree:
            self._tables = [univariate.table(Basis.CHEBYSHEV, row, degree) for row in self._t]
        return [table[: degree + 1] for table in self._tables]


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The values at the data and at the sign constraints that make up φ for one polynomial.

    Attributes
    ----------
    distance
        (N,), f/S at the data.
    size
        (N,), S at the data.
    direction
        (d, N), ∇f/S at the data.
    shortfalls
        One array for each set of sign constraints, of the set's own shape: v at its places.
    value
        φ.

    """

    distance: FloatArray
    size: FloatArray
    direction: FloatArray
    shortfalls: list[FloatArray]
    value: float


class Objective:
    """φ at one degree: its value, its normal equations, and the measures of the stopping rule.

    Attributes
    ----------
    data, signs, angle_weight, blend
        The data, the sets of sign constraints, λ and t; they may be changed between evaluations.
    degree, columns
        n, and the number m of coefficients.

    """

    def __init__(
        self, data: DataTables, degree: int, signs: Sequence[SignConstraints], angle_weight: float, blend: float = 1.0
    ) -> None:
        """Take the data, the degree, the sign constraints, λ, and the homotopy's t."""
        self.data, self.degree, self.signs = data, degree, list(signs)
        self.angle_weight, self.blend = angle_weight, blend
        d = data.dimension
        self.columns = graded.count(d, degree)
        self._pairs = np.triu_indices(d)
        self._kept = np.zeros((self.columns, self.columns))  # the data's part of the matrix …
        self._kept_of = (data, angle_weight, blend)  # … of these, …
        self._keep, self._age = 1, 1  # … for so many steps, of which so many are over
        self._place = gram.position(graded.exponents(d, degree), degree)
        D = [gram.differentiation(d, degree, k) / half for k, half in enumerate(data.half)]
        self._Dt = [M.toarray().T.copy() if self.columns <= DENSE_COLUMNS else M.T.tocsr() for M in D]

    def evaluate(self, a: FloatArray) -> Evaluation:
        """Return the values that make up φ for the polynomial with Chebyshev coefficients a (m,)."""
        d, w = self.data.dimension, self.data.weights
        tensors = evaluation.to_tensor(np.stack([a, *(a @ D for D in self._Dt)]), d, self.degree)
        values = evaluation.scattered(tensors, self.data.tables(self.degree))
        squared = np.einsum("kn,kn->n", values[1:], values[1:])
        size = np.sqrt(np.maximum(self.blend * squared + (1.0 - self.blend), FLATTEST**2))
        values /= size
        distance, direction = values[0], values[1:]
        shortfalls = [places.shortfall(tensors[0]) for places in self.signs]
        deviation = direction - self.data.normals
        value = w @ (distance**2 + self.angle_weight * np.einsum("kn,kn->n", deviation, deviation))
        for places, v in zip(self.signs, shortfalls, strict=True):
            value += places.cost(v)
        return Evaluation(distance, size, direction, shortfalls, float(value))

    def rows(self, most: int) -> tuple[FloatArray, FloatArray]:
        """Return the basis functions and their partial derivatives at n ≤ `most` of the data, (1 + d, n, m).

        The second array, (d, n), are the normals there.
        """
        some = slice(None, None, -(-len(self.data.weights) // most))
        tables = [table[:, some] for table in self.data.tables(self.degree)]
        P = graded.products(tables, graded.exponents(self.data.dimension, self.degree)).T
        return np.stack([P, *(P @ D.T for D in self._Dt)]), self.data.normals[:, some]

    def normal_equations(self, evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
        """Return the Gauss–Newton matrix H (m, m) and r (m,), half the negative gradient of φ."""
        u = self._gradient_factor(evaluation)
        first = gram.moments(self.data.tables(self.degree), self._slope_weights(evaluation, u))[self._place]
        r = -first[:, 0] - sum(D @ b for D, b in zip(self._Dt, first.T[1:], strict=True))
        active = np.zeros((graded.count(self.data.dimension, 2 * self.degree), 1))
        for places, v in zip(self.signs, evaluation.shortfalls, strict=True):
            active += places.active(v, self.degree)
            r += places.half_descent(v, self.degree)
        return self._matrix(evaluation, u, active), np.asarray(r)

    def keep_data_matrix(self, steps: int) -> None:
        """Let the data's part of the Gauss–Newton matrix be computed in every so many steps only, from the next one on.

        Steps with an old matrix still descend, for the gradient and the sign constraints' part are those of the place.
        """
        self._keep, self._age = steps, steps

    def _matrix(self, evaluation: Evaluation, u: FloatArray, active: FloatArray) -> FloatArray:
        """Return the Gauss–Newton matrix, given the moments of the active sign constraints."""
        d, of = self.data.dimension, (self.data, self.angle_weight, self.blend)
        if self._age >= self._keep or of != self._kept_of:
            mu = gram.moments(self.data.tables(2 * self.degree), self._matrix_weights(evaluation, u))
            if self._keep == 1:
                mu[:, :1] += active
                return self._assembled(gram.gram(mu, d, self.degree))
            self._kept, self._kept_of, self._age = self._assembled(gram.gram(mu, d, self.degree)), of, 0
        self._age += 1
        return np.asarray(self._kept + gram.gram(active, d, self.degree)[0])

    def closeness(self, evaluation: Evaluation) -> tuple[float, float]:
        """Return D_dist and D_smooth (see `search.criteria`), as means with the points' weights."""
        length = np.linalg.norm(evaluation.direction, axis=0)
        longest = float((length * evaluation.size).max())
        length = np.maximum(length, max(SHORTEST_GRADIENT * longest, np.finfo(float).tiny) / evaluation.size)
        cosine = (evaluation.direction * self.data.normals).sum(axis=0) / length
        w = self.data.weights
        return float(w @ (np.abs(evaluation.distance) / length)), float(w @ cosine)

    def _gradient_factor(self, evaluation: Evaluation) -> FloatArray:
        """Return u (N,), −t (f/S)/S: the row of f/S is P/S + u ĝ·∇P."""
        return -self.blend * evaluation.distance / evaluation.size

    def _matrix_weights(self, evaluation: Evaluation, u: FloatArray) -> FloatArray:
        """Return the weights (p, N) of the Gram matrices G_kl, k ≤ l: G_00, then G_0l, then the others row by row.

        They come from the square of the row of f/S, and from (I − t ĝĝᵀ)² = I − (2t − t²‖ĝ‖²) ĝĝᵀ.
        """
        t, g, w, (k, j) = self.blend, evaluation.direction, self.data.weights, self._pairs
        scale = self.angle_weight * w / evaluation.size**2
        out = np.empty((1 + len(g) + len(k), len(w)))
        out[0] = w / evaluation.size**2
        np.multiply(w * u / evaluation.size, g, out=out[1 : 1 + len(g)])
        along = w * u**2 - scale * (2.0 * t - t**2 * np.einsum("kn,kn->n", g, g))  # of ĝĝᵀ
        np.multiply(along * g[k], g[j], out=out[1 + len(g) :])
        out[1 + len(g) :][k == j] += scale
        return out

    def _slope_weights(self, evaluation: Evaluation, u: FloatArray) -> FloatArray:
        """Return the weights (1 + d, N) of the first moments b_k.

        Half the gradient of the data's terms is Σ D_kᵀ b_k.
        """
        t, g, w = self.blend, evaluation.direction, self.data.weights
        deviation = g - self.data.normals
        along = w * u * evaluation.distance - t * self.angle_weight * w / evaluation.size * np.einsum(
            "kn,kn->n", g, deviation
        )
        out = np.empty((1 + len(g), len(w)))
        out[0] = w * evaluation.distance / evaluation.size
        np.multiply(self.angle_weight * w / evaluation.size, deviation, out=out[1:])
        out[1:] += along * g
        return out

    def _assembled(self, G: FloatArray) -> FloatArray:
        """Return Σ D_kᵀ G_kl D_l (m, m), from the Gram matrices G_kl, k ≤ l, (p, m, m).

        G is symmetric, so this is S + Sᵀ with S = G_00/2 + Σ_k D_kᵀ (G_0k + G_kk D_k/2 + Σ_{l>k} G_kl D_l).
        """
        d, Dt = self.data.dimension, self._Dt
        rest = iter(G[1 + d :])
        S = G[0] / 2.0
        for k in range(d):
            row = (Dt[k] @ next(rest)).T / 2.0
            row += G[1 + k]
            for j in range(k + 1, d):
                row += (Dt[j] @ next(rest)).T
            S += Dt[k] @ row
        return np.asarray(S + S.T)
