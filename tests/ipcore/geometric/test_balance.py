from typing import cast

import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.geometric.balance import BALANCE_RANGE, balance
from ipcore.geometric.descent import Descent
from ipcore.geometric.levenberg_marquardt import Effort, Refined
from ipcore.geometric.objective import Evaluation, Objective

NOTHING = Evaluation(np.zeros(0), np.zeros(0), np.zeros((0, 0)), [], 0.0)


class Weighted:
    """An objective of which only λ is used."""

    angle_weight = 1.0


class Traded(Descent):
    """Excesses c·λ^½ of the distance and c/λ^½ of the angles, with λ/λ₀ kept in the coefficient of the fit."""

    def __init__(self, far: float, turned: float) -> None:
        self.objective = cast("Objective", Weighted())
        self.iterations, self._far, self._turned = 0, far, turned

    def refine(self, a: FloatArray, effort: Effort) -> Refined:
        self.iterations += min(1, effort.steps)
        return Refined(np.full_like(a, self.objective.angle_weight), NOTHING, 1)

    def excesses(self, fit: Refined) -> tuple[float, float]:
        root = float(fit.coefficients[0]) ** 0.5
        return self._far * root, self._turned / root

    def excess(self, fit: Refined) -> float:
        return max(self.excesses(fit))


def fit_at(weight: float) -> Refined:
    return Refined(np.array([weight]), NOTHING, 1)


@pytest.mark.parametrize(("far", "turned"), [(0.5, 1.5), (1.5, 0.5)])
def test_the_weight_moves_towards_the_half_that_is_not_met_until_both_are(far: float, turned: float) -> None:
    descent = Traded(far, turned)
    fit = balance(descent, fit_at(1.0), 1.0)
    assert descent.excess(fit) < 1.0
    assert (descent.objective.angle_weight > 1.0) == (turned > far)
    assert fit.coefficients[0] == descent.objective.angle_weight


@pytest.mark.parametrize(("far", "turned"), [(0.9, 0.9), (1.2, 1.2), (0.7, 2.0)])
def test_nothing_moves_if_both_are_met_or_cannot_be(far: float, turned: float) -> None:
    descent = Traded(far, turned)
    balance(descent, fit_at(1.0), 1.0)
    assert (descent.objective.angle_weight, descent.iterations) == (1.0, 0)


class Untraded(Traded):
    """Excesses that both grow with λ."""

    def excesses(self, fit: Refined) -> tuple[float, float]:
        root = float(fit.coefficients[0]) ** 0.5
        return self._far * root, self._turned * root


def test_the_weight_of_the_best_fit_is_kept_when_the_next_is_worse() -> None:
    descent, first = Untraded(0.5, 1.5), fit_at(1.0)
    assert balance(descent, first, 1.0) is first
    assert (descent.objective.angle_weight, descent.iterations) == (1.0, 1)


def test_the_weight_stays_within_its_range() -> None:
    descent = Traded(1e-6, 1e3)
    balance(descent, fit_at(1.0), 1.0)
    assert descent.objective.angle_weight == BALANCE_RANGE
