"""Bernstein coefficients against the values that they bound."""

from fractions import Fraction
from itertools import product
from math import comb

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


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_the_bounds_hold_for_computed_values_though_they_are_attained(dimension: int, seed: int) -> None:
    """Along every axis f rises, so on each block it is least and greatest at corners, where it equals a coefficient."""
    rng = np.random.default_rng(seed)
    a = 1e-3 * rng.normal(size=graded.count(dimension, 7))
    a[1 : 1 + dimension] = 1.0
    box = np.array([[-1.0] * dimension, [1.5] * dimension])
    p = ImplicitPolynomial(7, a, Frame(np.full(dimension, 0.1), 1.3), box, Basis.CHEBYSHEV)
    lines = [np.linspace(low, high, 14) for low, high in box.T]
    values = p.on_grid(lines)
    low, high = ranges(p, [np.stack([line[:-1], line[1:]]) for line in lines])
    first, last = values[(slice(None, -1),) * dimension], values[(slice(1, None),) * dimension]
    assert (low <= first).all()
    assert (high >= last).all()
    assert (first - low).max() < 1e3 * EPS  # so close that only the rounding is between them
    assert (high - last).max() < 1e3 * EPS


@pytest.mark.parametrize("basis", list(Basis))
@pytest.mark.parametrize("degree", [3, 12, 20])
def test_the_bounds_hold_for_the_exact_coefficients_and_the_exact_values(basis: Basis, degree: int) -> None:
    rng = np.random.default_rng(degree)
    a = rng.normal(size=graded.count(2, degree))
    frame, box = Frame(np.zeros(2), 1.0), np.array([[-1.0] * 2, [1.0] * 2])
    p = ImplicitPolynomial(degree, a, frame, box, basis)
    ends = np.array([[-1.0, 0.125], [-0.75, 1.0]])
    low, high = ranges(p, [ends, ends])
    rows = [_exact_matrix(basis, degree, Fraction(start), Fraction(stop)) for start, stop in ends.T.tolist()]
    for i, j in product(range(2), repeat=2):
        exact = _exact_products(p, rows[i], rows[j])
        assert Fraction(float(low[i, j])) <= min(exact)
        assert max(exact) <= Fraction(float(high[i, j]))


def _exact_matrix(basis: Basis, n: int, start: Fraction, stop: Fraction) -> list[list[Fraction]]:
    """Return the Bernstein coefficients [k][j] of each univariate function k on an interval, without rounding."""
    powers = [[Fraction(1)]]
    for k in range(1, n + 1):
        twice = 2 if basis is Basis.CHEBYSHEV and k > 1 else 1
        new = [Fraction(0)] * (k + 1)
        for j, c in enumerate(powers[-1]):
            new[j] += twice * start * c
            new[j + 1] += twice * (stop - start) * c
        for j, c in enumerate(powers[-2] if twice == 2 else []):
            new[j] -= c
        powers.append(new)
    return [
        [
            sum((c * Fraction(comb(j, i), comb(n, i)) for i, c in enumerate(row[: j + 1])), Fraction(0))
            for j in range(n + 1)
        ]
        for row in powers
    ]


def _exact_products(p: ImplicitPolynomial, x: list[list[Fraction]], y: list[list[Fraction]]) -> list[Fraction]:
    """Return the Bernstein coefficients of a polynomial on one block, without rounding."""
    n = p.degree
    terms = [(Fraction(c), k, m) for c, (k, m) in zip(p.coefficients.tolist(), p.exponents.tolist(), strict=True)]
    along_x = [
        [sum((c * x[k][i] for c, k, m in terms if m == second), Fraction(0)) for second in range(n + 1)]
        for i in range(n + 1)
    ]
    return [
        sum((along_x[i][m] * y[m][j] for m in range(n + 1)), Fraction(0)) for i in range(n + 1) for j in range(n + 1)
    ]


def test_a_linear_polynomial_has_exact_ranges() -> None:
    p = ImplicitPolynomial(1, np.array([0.5, 2.0, -1.0]), Frame(np.zeros(2), 1.0), np.array([[-1.0, -1.0], [1.0, 1.0]]))
    low, high = ranges(p, [np.array([[-1.0, 0.0], [0.0, 1.0]]), np.array([[-1.0], [1.0]])])
    np.testing.assert_allclose(low, [[-2.5], [-0.5]], atol=50 * EPS)
    np.testing.assert_allclose(high, [[1.5], [3.5]], atol=50 * EPS)
