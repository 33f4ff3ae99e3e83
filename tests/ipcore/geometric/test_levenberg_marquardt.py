import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.geometric.levenberg_marquardt import refine, solve, unit_diagonal
from ipcore.geometric.objective import Evaluation

EPS = np.finfo(float).eps


class Valley:
    """Rosenbrock's function as a sum of squares: (10 (y − x²))² + (1 − x)², its minimum 0 at (1, 1)."""

    def evaluate(self, a: FloatArray) -> Evaluation:
        residual = np.array([10.0 * (a[1] - a[0] ** 2), 1.0 - a[0]])
        return Evaluation(residual, a, a, [], float(residual @ residual))

    def normal_equations(self, evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
        J = np.array([[-20.0 * evaluation.size[0], 10.0], [-1.0, 0.0]])
        return J.T @ J, -J.T @ evaluation.distance


def test_a_bent_valley_is_followed_to_its_end() -> None:
    fit = refine(Valley(), np.array([-1.2, 1.0]), 100, 1e-12, 3)
    np.testing.assert_allclose(fit.coefficients, [1.0, 1.0], atol=1e-6)
    assert fit.steps < 50


def test_no_more_steps_than_allowed_and_none_up() -> None:
    start = np.array([-1.2, 1.0])
    values = [refine(Valley(), start, steps, 0.0, 1).evaluation.value for steps in (1, 2, 4, 8)]
    assert values == sorted(values, reverse=True)
    assert values[0] < Valley().evaluate(start).value


def test_at_the_minimum_nothing_moves() -> None:
    fit = refine(Valley(), np.array([1.0, 1.0]), 10, 1e-3, 1)
    assert fit.coefficients.tolist() == [1.0, 1.0]


@pytest.mark.parametrize("scale", [1.0, 1e6])
def test_badly_scaled_equations_are_solved(scale: float) -> None:
    Q = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))[0]
    H = (Q * np.geomspace(1.0, 1e-3, 6)) @ Q.T
    s = np.geomspace(1.0, scale, 6)
    x = np.ones(6)
    solved = solve(H * s * s[:, None], (H * s * s[:, None]) @ x)
    np.testing.assert_allclose(solved, x, atol=1e4 * EPS)
    np.testing.assert_allclose(np.diag(unit_diagonal(H * s * s[:, None])[0]), 1.0, atol=4.0 * EPS)


def test_singular_equations_have_a_solution() -> None:
    H = np.ones((2, 2))
    x = solve(H, np.array([2.0, 2.0]))
    np.testing.assert_allclose(H @ x, [2.0, 2.0], atol=1e-6)


def test_indefinite_equations_are_refused() -> None:
    with pytest.raises(ArithmeticError, match="positive definite"):
        solve(np.array([[1.0, 2.0], [2.0, 1.0]]), np.ones(2))
