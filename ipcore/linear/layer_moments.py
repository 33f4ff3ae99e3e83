r"""The moments of a point set's layers, x + o n: all that a linear fit to values of f on layers needs of its points.

With m(x) the monomials of the frame, the entries of MᵀM = Σ m mᵀ are sums of monomials of up to twice the degree,

    μ_ijk = Σ x^i y^j z^k,    i + j + k ≤ 2n.

There are C(2n + d, d) of them, however many points there are. With the rows f(x + o n) = o, one layer per offset o, Mᵀb
is Σ o μ and bᵀb is N Σ o². Moments of two point sets add up to those of both together.

Monomials of the frame, not Chebyshev products: with columns scaled to length 1 their condition is lower (3L at degree
12: 1.6e7 on the bunny, where Chebyshev products on its box have 3e7, and 4e8 on the fit's larger bounds). And each
entry of MᵀM is one sum, not a mean of eight, so its rounding is relative to the columns' own lengths.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np

from ipcore._typing import FloatArray, IntArray
from ipcore.linear.qr.r_factor import RFactor
from ipcore.polynomial import evaluation, graded, gram, univariate
from ipcore.polynomial.univariate import Basis

LAYER_CHUNK_POINTS = 8192  # points at once, as in `ipcore.polynomial.gram`


@dataclass(frozen=True, eq=False)
class LayerMoments:
    """The moments of the layers of N points.

    Attributes
    ----------
    degree
        n, the highest degree of a polynomial that can be fitted.
    offsets
        o of each layer, in mean radii.
    count
        N.
    sums
        (layers, C(2n + d, d)), μ in the order of `gram.order`(d, 2n).

    """

    degree: int
    offsets: tuple[float, ...]
    count: int
    sums: FloatArray

    @classmethod
    def empty(cls, d: int, degree: int, offsets: tuple[float, ...]) -> Self:
        """Return the moments of no points in d dimensions."""
        return cls(degree, offsets, 0, np.zeros((len(offsets), graded.count(d, 2 * degree))))

    @classmethod
    def of(cls, points: FloatArray, normals: FloatArray, degree: int, offsets: tuple[float, ...]) -> Self:
        """Return the moments of points (N, d) with unit normals (N, d), both in the normalised frame.

        >>> x = np.array([[1.0, 0.0], [0.0, 1.0]])
        >>> LayerMoments.of(x, x, 1, (0.0, 0.5)).sums.tolist()                     # 1, x, x²; y, xy; y²
        [[2.0, 1.0, 1.0, 1.0, 0.0, 1.0], [2.0, 1.5, 2.25, 1.5, 0.0, 2.25]]
        """
        sums = cls.empty(points.shape[1], degree, offsets).sums
        for start in range(0, len(points), LAYER_CHUNK_POINTS):
            x, n = points[start : start + LAYER_CHUNK_POINTS].T, normals[start : start + LAYER_CHUNK_POINTS].T
            ones = np.ones((1, x.shape[1]))
            for layer, offset in enumerate(offsets):
                sums[layer] += gram.moments(tables(x + offset * n, 2 * degree), ones)[:, 0]
        return cls(degree, offsets, len(points), sums)

    def __add__(self, other: "LayerMoments") -> "LayerMoments":
        """Return the moments of both point sets together; degree and offsets must be the same."""
        return LayerMoments(self.degree, self.offsets, self.count + other.count, self.sums + other.sums)

    @property
    def dimension(self) -> int:
        """Return d."""
        return 2 if self.sums.shape[1] == graded.count(2, 2 * self.degree) else 3

    def r_factor(self) -> RFactor:
        """Return R and b̃ of the rows of all layers, from MᵀM and Mᵀb."""
        d, n, o = self.dimension, self.degree, np.array(self.offsets)
        G = self.sums.sum(axis=0)[_pairs(d, n)]
        g = (o @ self.sums)[gram.position(graded.exponents(d, n), 2 * n)]
        return RFactor.of_normal_equations(G, g, self.count * float(o @ o), len(o) * self.count)


def normal_residuals(
    points: FloatArray, normals: FloatArray, degree: int, offsets: tuple[float, ...], A: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the residuals Mᵀ(b − M a), (m, p), of the normal equations, and ‖b − M a‖², (p,).

    M has the rows of all layers of points (N, d), with normals (N, d). The columns a of A (m, p) are the coefficients
    of p polynomials up to `degree`, in graded order. b − M a is formed row by row, so the condition is not squared.
    """
    d, (m, p) = points.shape[1], A.shape
    tensors, out, rss = evaluation.to_tensor(A.T, d, degree), np.zeros((m, p)), np.zeros(p)
    for start in range(0, len(points), LAYER_CHUNK_POINTS):
        x, n = points[start : start + LAYER_CHUNK_POINTS].T, normals[start : start + LAYER_CHUNK_POINTS].T
        for offset in offsets:
            table = tables(x + offset * n, degree)
            residuals = offset - evaluation.scattered(tensors, table)
            out += gram.in_graded_order(gram.moments(table, residuals), d, degree)
            rss += np.einsum("pn,pn->p", residuals, residuals)
    return out, rss


def tables(x: FloatArray, degree: int) -> list[FloatArray]:
    """Return the powers 0 … n of every coordinate of x (d, N), d tables (n+1, N)."""
    powers = univariate.table(Basis.MONOMIAL, x.reshape(-1), degree).reshape(degree + 1, *x.shape)
    return [powers[:, axis] for axis in range(len(x))]


@lru_cache(maxsize=4)
def _pairs(dimension: int, degree: int) -> IntArray:
    """Return the position among the moments of every entry of Σ m mᵀ, (m, m)."""
    E = graded.exponents(dimension, degree)
    where = gram.position(E[:, None] + E, 2 * degree)
    where.setflags(write=False)
    return where
