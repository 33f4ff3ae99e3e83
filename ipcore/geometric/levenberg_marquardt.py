"""The Levenberg–Marquardt method: Gauss–Newton steps, damped until they decrease the objective.

The damping follows Nielsen (Damping parameter in Marquardt's method, IMM-REP-1999-05). After a step that decreases the
objective as much as its quadratic model predicts, the damping falls tenfold; after a step that does not decrease it,
the damping grows, by a factor that doubles each time. A step that cannot be computed counts as one that does not
decrease it.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import lapack

from ipcore._typing import FloatArray
from ipcore.geometric.objective import Evaluation

# Dampings are relative to a unit diagonal. With a larger first one, the coefficients that a degree adds stay near 0,
# and the fit stays in the minimum of the degree below.
FIRST_DAMPING = 1e-6
LEAST_DAMPING = 1e-12
GREATEST_FALL = 0.1  # the factor by which the damping falls after a step that the model predicts well
BEST_AGREEMENT = 1e3  # of the gain with the prediction; a greater one says nothing more
DAMPING_TRIALS = 12  # per step: the last damping is 2⁷⁷ times the first, which leaves no step at all
# Added to the unit diagonal beside the damping, one after the other, if rounding has made the matrix indefinite.
DIAGONAL_SHIFTS = (0.0, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9)


class LeastSquares(Protocol):
    """A sum of squares, by its value and its normal equations."""

    def evaluate(self, a: FloatArray) -> Evaluation:
        """Return the evaluation at the coefficients a (m,)."""
        ...

    def normal_equations(self, evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
        """Return the Gauss–Newton matrix (m, m) and half the negative gradient (m,) at an evaluated point."""
        ...


@dataclass(frozen=True, eq=False)
class Refined:
    """The result of a refinement: the coefficients (m,), their evaluation, and the number of steps taken."""

    coefficients: FloatArray
    evaluation: Evaluation
    steps: int


@dataclass(frozen=True)
class Effort:
    """When a refinement ends.

    Attributes
    ----------
    steps
        The largest number of steps.
    tolerance, patience
        It ends earlier after `patience` steps in succession that each decrease the objective by a smaller share than
        `tolerance`.

    """

    steps: int
    tolerance: float
    patience: int


def refine(objective: LeastSquares, a: FloatArray, effort: Effort) -> Refined:
    """Decrease the objective step by step from the coefficients a (m,), with the given effort."""
    evaluation, damping, slow, step = objective.evaluate(a), FIRST_DAMPING, 0, 0
    for step in range(1, effort.steps + 1):  # noqa: B007 - the number of steps is part of the answer
        H, r = objective.normal_equations(evaluation)
        scaled, s = unit_diagonal(H)
        grow = 4.0
        for _ in range(DAMPING_TRIALS):
            solved = _solved(scaled, s * r, damping)
            if solved is not None:
                p = s * solved
                there = objective.evaluate(a + p)
                if there.value < evaluation.value:
                    break
            damping, grow = damping * grow, grow * 2.0
        else:
            break
        gain = evaluation.value - there.value
        predicted = float(p @ (2.0 * r - H @ p))  # which rounding may make 0 or less, where steps are tiny
        agreement = min(gain / predicted, BEST_AGREEMENT) if predicted > 0.0 else 0.0
        slow = slow + 1 if gain < effort.tolerance * evaluation.value else 0
        a, evaluation = a + p, there
        damping = max(damping * max(GREATEST_FALL, 1.0 - (2.0 * agreement - 1.0) ** 3), LEAST_DAMPING)
        if slow == effort.patience:
            break
    return Refined(a, evaluation, step)


def _solved(scaled: FloatArray, r: FloatArray, damping: float) -> FloatArray | None:
    """Return p (m,) with (scaled + damping · 1) p = r, where `scaled` (m, m) has diagonal 1, and r is (m,).

    Return None if rounding has made the matrix indefinite, even with the greatest shift of its diagonal. At a point
    where f and ∇f vanish together, the weights of the Gram matrices differ by so much that this happens.
    """
    for shift in DIAGONAL_SHIFTS:
        A = scaled.copy()
        A.flat[:: len(A) + 1] = 1.0 + damping + shift
        # the transpose of a symmetric matrix is the same matrix in Fortran order, of which LAPACK makes no copy
        factor, failed = lapack.dpotrf(A.T, clean=False, overwrite_a=True)
        if not failed:
            return np.asarray(lapack.dpotrs(factor, r)[0])
    return None


def unit_diagonal(H: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return S H S, which has diagonal 1, and the diagonal (m,) of the diagonal matrix S; H is (m, m)."""
    s = 1.0 / np.sqrt(np.maximum(np.diag(H), np.finfo(float).tiny))
    return H * s * s[:, None], s


def condition(H: FloatArray) -> tuple[float, float]:
    """Return two measures of the condition of a Jacobian J, given H = JᵀJ (m, m).

    The first is the estimated condition of J with columns scaled to length 1. The second is the paper's, max |r_ii| /
    min |r_ii| of the factor R of J. Both are infinite if H is not positive definite.
    """
    scaled, _ = unit_diagonal(H)
    norm = np.abs(scaled).sum(axis=0).max()
    factor, failed = lapack.dpotrf(scaled.T, clean=False, overwrite_a=True)
    if failed:
        return float("inf"), float("inf")
    reciprocal = lapack.dpocon(factor, norm)[0]
    diagonal = np.abs(np.diag(factor)) * np.sqrt(np.diag(H))
    return float(max(reciprocal, np.finfo(float).tiny) ** -0.5), float(diagonal.max() / diagonal.min())
