"""What bounds a polynomial in Chebyshev products, and its derivatives, on −1 … 1: weights of its coefficients."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np

from ipcore._typing import FloatArray
from ipcore.proof.intervals import to_bernstein


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of the (n+1)^d coefficients c_ijk.

    Attributes
    ----------
    beyond
        (n, (n+1)^d), in row s 1 for the products with a function of a higher degree than s, else 0.
    squares
        (d, (n+1)^d), i², j², k²: bounds of the derivatives of the products.
    largest
        ((n+1)^d,), the product of the largest Bernstein coefficients of T_i, T_j and T_k.

    """

    beyond: FloatArray
    squares: FloatArray
    largest: FloatArray

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, dimension: int, degree: int) -> Self:
        """Return the weights for tensors (n+1, …)."""
        degrees = np.indices((degree + 1,) * dimension).reshape(dimension, -1)
        return cls(
            beyond=(degrees.max(axis=0) > np.arange(degree)[:, None]).astype(float),
            squares=degrees.astype(float) ** 2,
            largest=np.abs(to_bernstein(degree)).max(axis=0)[degrees].prod(axis=0),
        )
