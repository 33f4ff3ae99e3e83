"""Bernstein coefficients against the values that they bound."""

import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.bernstein import matrices, ranges
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis, table

EPS = float(np.finfo(float).eps)


def bernstein(n: int, u: FloatArray) -> FloatArray:
    """Return the Bernstein polynomials (n+1, M) at u by de Casteljau's recurrence."""
    B = np.zeros((n + 1, len(u)))
    B[0] = 1.0
    for _ in range(n):
        B[1:], B[0] = (1.0 - u) * B[1:] + u * B[:-1], (1.0 - u) * B[0]
    return B


@pytest.mark.parametrize("basis", list(Basis))
@pytest.mark.parametrize("degree", [0, 1, 2, 7, 20])
def test_matrices_give_the_same_polynomial(basis: Basis, degree: int) -> None:
    ends = np.array([[-1.0, -0.2, 0.4], [-0.9, 0.3, 0.4]])  # the last one has no length
    u = np.linspace(0.0, 1.0, 7)
    for matrix, (start, stop) in zip(matrices(basis, degree, ends), ends.T, strict=True):
        values = table(basis, start + (stop - start) * u, degree)
        np.testing.assert_allclose(matrix.T @ bernstein(degree, u), values, atol=100 * (degree + 1) * EPS)


@pytest.mark.parametrize("basis", list(Basis))
@pytest.mark.parametrize("dimension", [2, 3])
def test_ranges_hold_the_values_and_close_in_on_them(basis: Basis, dimension: int) -> None:
    rng = np.random.default_rng(dimension)
    a = rng.normal(size=graded.count(dimension, 9))
    box = np.array([[-1.0] * dimension, [1.5] * dimension])
    p = ImplicitPolynomial(9, a, Frame(np.full(dimension, 0.2), 1.1), box, basis)
    widths = []
    for blocks in (4, 8, 16):
        lines = [np.linspace(low, high, 6 * blocks + 1) for low, high in box.T]
        least, most = ranges(p, [np.stack([line[:-1:6], line[6::6]]) for line in lines])
        values = p.on_grid(lines)
        windows = np.lib.stride_tricks.sliding_window_view(values, (7,) * dimension)[
            (slice(None, None, 6),) * dimension
        ]
        within = tuple(range(dimension, 2 * dimension))
        assert (least <= windows.min(axis=within)).all()
        assert (most >= windows.max(axis=within)).all()
        widths.append(((most - least) - np.ptp(windows, axis=within)).mean())
    assert widths[1] < widths[0] / 3  # towards a quarter: the gap falls with the square of the blocks' size
    assert widths[2] < widths[1] / 3.5


def test_a_linear_polynomial_has_exact_ranges() -> None:
    p = ImplicitPolynomial(1, np.array([0.5, 2.0, -1.0]), Frame(np.zeros(2), 1.0), np.array([[-1.0, -1.0], [1.0, 1.0]]))
    low, high = ranges(p, [np.array([[-1.0, 0.0], [0.0, 1.0]]), np.array([[-1.0], [1.0]])])
    np.testing.assert_allclose(low, [[-2.5], [-0.5]], atol=50 * EPS)
    np.testing.assert_allclose(high, [[1.5], [3.5]], atol=50 * EPS)
