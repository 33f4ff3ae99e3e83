import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.geometric.levenberg_marquardt import FIRST_DAMPING, Effort, condition, refine, unit_diagonal
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


class Linear:
    """The sum of squares ‖J a − b‖², or one with any matrix H in the place of JᵀJ."""

    def __init__(self, J: FloatArray, b: FloatArray, H: FloatArray | None = None) -> None:
        self.J, self.b, self.H = J, b, J.T @ J if H is None else H

    def evaluate(self, a: FloatArray) -> Evaluation:
        residual = self.J @ a - self.b
        return Evaluation(residual, a, a, [], float(residual @ residual))

    def normal_equations(self, evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
        return self.H, -self.J.T @ evaluation.distance


def test_a_bent_valley_is_followed_to_its_end() -> None:
    fit = refine(Valley(), np.array([-1.2, 1.0]), Effort(100, 1e-12, 3))
    np.testing.assert_allclose(fit.coefficients, [1.0, 1.0], atol=1e-6)
    assert fit.steps < 50


def test_no_more_steps_than_allowed_and_none_up() -> None:
    start = np.array([-1.2, 1.0])
    fits = [refine(Valley(), start, Effort(steps, 0.0, 1)) for steps in (1, 2, 4, 8)]
    assert [fit.steps for fit in fits] == [1, 2, 4, 8]
    values = [fit.evaluation.value for fit in fits]
    assert values == sorted(values, reverse=True)
    assert values[0] < Valley().evaluate(start).value


@pytest.mark.parametrize("patience", [1, 3])
def test_it_ends_after_as_many_small_gains_in_succession_as_it_has_patience(patience: int) -> None:
    # every step gains less than all of the value, so each of the first ones is too small for a tolerance of 1
    fit = refine(Valley(), np.array([-1.2, 1.0]), Effort(100, 1.0, patience))
    assert fit.steps == patience


class Scripted:
    """An objective whose values are given in advance, one for each evaluation."""

    def __init__(self, *values: float) -> None:
        self._values, self.places = iter(values), list[float]()

    def evaluate(self, a: FloatArray) -> Evaluation:
        self.places.append(float(a[0]))
        return Evaluation(a, a, a, [], next(self._values))

    def normal_equations(self, evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
        return np.eye(len(evaluation.size)), np.ones(len(evaluation.size))


def test_a_large_gain_renews_the_patience() -> None:
    fit = refine(Scripted(100.0, 99.0, 50.0, 49.5, 20.0, 19.9, 19.8), np.zeros(1), Effort(100, 0.1, 2))
    assert (fit.steps, fit.evaluation.value) == (6, 19.8)


@pytest.mark.parametrize(("agreement", "factor"), [(1.0, 0.1), (0.5, 1.0), (0.1, 1.512)])
def test_damping_follows_the_agreement_of_gain_and_model(agreement: float, factor: float) -> None:
    """With H = r = 1 a step is 1/(1 + μ), from which the damping μ is read; the model predicts a gain of p (2 − p)."""
    rising = [2.0] * 6  # after which the damping is 4 · 8 · … · 128 times the first
    damping = FIRST_DAMPING * 2.0**27
    step = 1.0 / (1.0 + damping)
    script = Scripted(1.0, *rising, 1.0 - agreement * step * (2.0 - step), 0.0)
    refine(script, np.zeros(1), Effort(2, 0.0, 2))
    *_, here, there = script.places
    assert here == pytest.approx(step, rel=1e-12)
    assert 1.0 / (there - here) - 1.0 == pytest.approx(factor * damping, rel=1e-6)


def test_at_the_minimum_nothing_moves() -> None:
    fit = refine(Valley(), np.array([1.0, 1.0]), Effort(10, 1e-3, 1))
    assert fit.coefficients.tolist() == [1.0, 1.0]


@pytest.mark.parametrize("scale", [1.0, 1e6])
def test_the_size_of_the_variables_does_not_matter(scale: float) -> None:
    Q = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))[0]
    J, s = Q * np.geomspace(1.0, 0.1, 6) @ Q.T, np.geomspace(1.0, scale, 6)
    fit = refine(Linear(J * s, J @ np.ones(6)), np.zeros(6), Effort(1, 0.0, 1))
    # one Gauss–Newton step, but for the first damping of 1e-6 relative to the diagonal, magnified by the condition
    np.testing.assert_allclose(s * fit.coefficients, np.ones(6), atol=1e-3)
    np.testing.assert_allclose(np.diag(unit_diagonal((J * s).T @ (J * s))[0]), 1.0, atol=4.0 * EPS)


def test_singular_equations_have_a_solution() -> None:
    J = np.array([[1.0, 1.0]])
    fit = refine(Linear(J, np.array([2.0])), np.zeros(2), Effort(5, 1e-12, 1))
    np.testing.assert_allclose(J @ fit.coefficients, [2.0], atol=1e-6)


def test_a_step_that_cannot_be_computed_is_tried_again_with_more_damping() -> None:
    indefinite = Linear(np.eye(2), np.ones(2), np.array([[1.0, 2.0], [2.0, 1.0]]))
    start = indefinite.evaluate(np.zeros(2)).value
    assert refine(indefinite, np.zeros(2), Effort(1, 0.0, 1)).evaluation.value < start


def test_where_no_step_can_be_computed_the_fit_is_the_start() -> None:
    unusable = Linear(np.eye(2), np.ones(2), np.full((2, 2), np.nan))
    assert refine(unusable, np.zeros(2), Effort(3, 0.0, 1)).coefficients.tolist() == [0.0, 0.0]


def test_the_condition_is_that_of_the_jacobian_with_columns_of_length_1() -> None:
    J = np.random.default_rng(0).normal(size=(40, 5)) * np.geomspace(1.0, 1e5, 5)
    estimated, paper = condition(J.T @ J)
    true = np.linalg.cond(J / np.linalg.norm(J, axis=0))
    assert true / 3.0 < estimated < 3.0 * true  # LAPACK estimates in the 1-norm
    diagonal = np.abs(np.diag(np.linalg.qr(J, mode="r")))
    assert paper == pytest.approx(diagonal.max() / diagonal.min(), rel=1e-8)
    assert condition(np.array([[1.0, 2.0], [2.0, 1.0]])) == (np.inf, np.inf)


class Shrinking:
    """An objective whose model predicts nothing, though its value falls."""

    def __init__(self) -> None:
        self.value = 1.0

    def evaluate(self, a: FloatArray) -> Evaluation:  # noqa: ARG002 - the same everywhere
        self.value *= 0.5
        empty = np.zeros(0)
        return Evaluation(empty, empty, empty, [], self.value)

    def normal_equations(self, _: Evaluation) -> tuple[FloatArray, FloatArray]:
        return np.eye(2), np.zeros(2)


def test_a_model_that_predicts_no_gain_is_no_error() -> None:
    assert refine(Shrinking(), np.zeros(2), Effort(5, 0.0, 9)).steps == 5
