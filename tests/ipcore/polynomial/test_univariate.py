import numpy as np
import pytest
from numpy.polynomial import chebyshev, polynomial

from ipcore.polynomial import univariate
from ipcore.polynomial.univariate import Basis

T = np.linspace(-1.1, 1.1, 23)


@pytest.mark.parametrize(
    ("kind", "reference"), [(Basis.MONOMIAL, polynomial.polyval), (Basis.CHEBYSHEV, chebyshev.chebval)]
)
def test_table_holds_each_function(kind: Basis, reference: object) -> None:
    assert callable(reference)
    values = univariate.table(kind, T, 12)
    for k in range(13):
        np.testing.assert_allclose(values[k], reference(T, np.eye(13)[k]), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    ("kind", "reference"), [(Basis.MONOMIAL, polynomial.polyder), (Basis.CHEBYSHEV, chebyshev.chebder)]
)
def test_differentiation_matrix(kind: Basis, reference: object) -> None:
    assert callable(reference)
    a = np.random.default_rng(0).normal(size=10)
    np.testing.assert_allclose((univariate.differentiation(kind, 9) @ a)[:9], reference(a), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("kind", list(Basis))
def test_degree_zero(kind: Basis) -> None:
    np.testing.assert_array_equal(univariate.table(kind, T, 0), np.ones((1, len(T))))
    np.testing.assert_array_equal(univariate.differentiation(kind, 0), [[0.0]])


def test_change_of_basis_reproduces_the_function() -> None:
    slope, offset, degree = 0.6, 0.25, 20
    K = univariate.chebyshev_to_powers(degree, slope, offset)
    u = np.linspace(-1.0, 1.0, 50)
    powers = univariate.table(Basis.MONOMIAL, u, degree)
    direct = univariate.table(Basis.CHEBYSHEV, slope * u + offset, degree)
    growth = np.abs(K).sum(axis=0).astype(float)  # what rounding the powers' coefficients to doubles can cost
    error = np.abs(K.T.astype(float) @ powers - direct).max(axis=1)
    assert (error <= 8.0 * np.finfo(float).eps * growth).all()


def test_the_changes_of_basis_are_each_others_inverse() -> None:
    slope, offset, degree = 0.6, 0.25, 20
    K, L = univariate.chebyshev_to_powers(degree, slope, offset), univariate.powers_to_chebyshev(degree, slope, offset)
    size = np.abs(K).astype(float) @ np.abs(L).astype(float)
    error = np.abs((K @ L).astype(float) - np.eye(degree + 1))
    assert (error <= 100.0 * np.finfo(float).eps * np.maximum(size, 1.0)).all()
    assert np.array_equal(np.tril(L, -1), np.zeros_like(L))
