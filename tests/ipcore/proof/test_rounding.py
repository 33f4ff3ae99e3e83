"""Bounds of the rounding of values against rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

from ipcore.polynomial.univariate import Basis
from ipcore.proof.rounding import EPSILON, lost_in_rounding, roundings
from tests.ipcore.proof.exact import polynomial, univariate, value


@pytest.mark.parametrize("basis", list(Basis))
@pytest.mark.parametrize(("dimension", "degree"), [(2, 3), (2, 18), (3, 7)])
def test_values_have_no_more_roundings(basis: Basis, dimension: int, degree: int) -> None:
    p = polynomial(dimension, degree, degree, basis, 1.0)
    x = np.random.default_rng(1).uniform(p.bounds[0], p.bounds[1], (20, dimension))
    x[0], x[1] = p.bounds
    f = p(x)
    for place, computed in zip(x.tolist(), f.tolist(), strict=True):
        t = [Fraction(one) for one in place]
        if basis is Basis.CHEBYSHEV:
            low, high = ([Fraction(float(one)) for one in bound] for bound in p.bounds)
            t = [2 * (one - a) / (b - a) - 1 for one, a, b in zip(t, low, high, strict=True)]
        functions = [univariate(basis, degree, one)[0] for one in t]
        error = abs(value(p.tensor, functions) - Fraction(computed))
        most = [[max(abs(one), Fraction(basis is Basis.CHEBYSHEV)) for one in column] for column in functions]
        allowed = (
            roundings(p) * Fraction(EPSILON) * value(np.abs(p.tensor), [[Fraction(one) for one in c] for c in most])
        )
        assert error <= allowed
        assert allowed < 1e-9
        shifted = np.array([1.01, 0.99]) * float(allowed)
        assert lost_in_rounding(p, np.array([place] * 2), shifted)[1]


def test_a_sign_is_certain_beyond_the_bound_of_its_own_place() -> None:
    p = polynomial(2, 12, 3, Basis.MONOMIAL, 3.0)
    x = np.array([[0.1, 0.1], [2.5, 2.5], [0.1, 0.1], [0.1, 0.1]])
    f = np.array([1e-10, 1e-10, -1e-10, 0.0])
    assert lost_in_rounding(p, x, f).tolist() == [False, True, False, True]
    assert lost_in_rounding(p, x[:0], f[:0]).tolist() == []
