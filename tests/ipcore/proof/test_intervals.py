"""Univariate functions on intervals against rational arithmetic."""

from fractions import Fraction
from math import comb

import numpy as np
import pytest

from ipcore.polynomial.univariate import Basis
from ipcore.proof.intervals import halving, local, to_bernstein
from tests.ipcore.proof.exact import univariate


def exact(basis: Basis, degree: int, low: Fraction, high: Fraction) -> list[list[Fraction]]:
    """Return the Chebyshev coefficients on an interval of each function, from u = m + h s times the one before."""
    m, h = (low + high) / 2, (high - low) / 2

    def times_u(a: list[Fraction]) -> list[Fraction]:
        out = [m * one for one in a]
        for i, one in enumerate(a):
            for to in {i + 1, abs(i - 1)} if i else {1}:
                if to < len(a):
                    out[to] += h * one * (Fraction(1, 2) if i else 1)
        return out

    columns = [[Fraction(1)] + [Fraction(0)] * degree]
    for k in range(1, degree + 1):
        twice = 2 if basis is Basis.CHEBYSHEV and k > 1 else 1
        before = columns[k - 2] if twice == 2 else [Fraction(0)] * (degree + 1)
        columns.append([twice * new - old for new, old in zip(times_u(columns[-1]), before, strict=True)])
    return columns


@pytest.mark.parametrize("basis", list(Basis))
@pytest.mark.parametrize(
    ("low", "high"), [(-1.0, -0.75), (0.3, 0.7), (0.875, 1.0 + 2.0**-29), (-1.3, -0.2), (1.5, 2.5)]
)
def test_functions_are_exact_within_their_bound(basis: Basis, low: float, high: float) -> None:
    degree = 16
    X, off = local(basis, degree, np.array([low, -1.0]), np.array([high, 1.0]), max(abs(low), abs(high)))
    for k, column in enumerate(exact(basis, degree, Fraction(low), Fraction(high))):
        error = sum(abs(one - Fraction(float(x))) for one, x in zip(column, X[0, :, k], strict=True))
        assert error <= off[0, k]
    largest = np.abs(X).sum(axis=1)
    assert (off[0] <= 1e-9 * largest[0].max()).all()
    if max(-low, high) < 1.0 + 1e-6:
        assert (off[0] <= 1e-12).all()


@pytest.mark.parametrize("degree", [1, 2, 7, 20])
def test_halving_is_exact(degree: int) -> None:
    for half, ends in zip(halving(degree), ((-1, 0), (0, 1)), strict=True):
        for k, column in enumerate(exact(Basis.CHEBYSHEV, degree, Fraction(ends[0]), Fraction(ends[1]))):
            assert [Fraction(float(x)) for x in half[:, k]] == column


@pytest.mark.parametrize("degree", [1, 2, 5, 12])
def test_bernstein_coefficients_enclose(degree: int) -> None:
    b = to_bernstein(degree)
    np.testing.assert_allclose(b[0], [(-1.0) ** k for k in range(degree + 1)], atol=1e-15)
    np.testing.assert_allclose(b[-1], 1.0, atol=1e-15)
    np.testing.assert_allclose(b[:, 1], np.linspace(-1.0, 1.0, degree + 1), atol=1e-15)
    for s in (Fraction(-1, 3), Fraction(1, 7), Fraction(3, 4)):
        values = np.array([float(one) for one in univariate(Basis.CHEBYSHEV, degree, s)[0]])
        assert (b.min(axis=0) - 1e-12 <= values).all()
        assert (values <= b.max(axis=0) + 1e-12).all()


@pytest.mark.parametrize("degree", [3, 12, 24, 40])
def test_bernstein_coefficients_are_rounded_once(degree: int) -> None:
    """T_n itself has (−1)^(n−j) C(2n, 2j) / C(n, j)."""
    b = to_bernstein(degree)
    exact_ones = [Fraction((-1) ** (degree - j) * comb(2 * degree, 2 * j), comb(degree, j)) for j in range(degree + 1)]
    assert b[:, degree].tolist() == [float(one) for one in exact_ones]
