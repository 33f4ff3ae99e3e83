"""Levenberg–Marquardt: Gauss–Newton steps, damped until they lead down.

The damping follows Nielsen (Damping parameter in Marquardt's method, IMM-REP-1999-05): after a step that gains as much
as the quadratic model says it falls tenfold, after one that gains nothing it grows, faster each time.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import lapack

from ipcore._typing import FloatArray
from ipcore.geometric.objective import Evaluation

# Relative to a unit diagonal. More keeps the new coefficients of a degree near 0, and the fit in the old one's minimum.
FIRST = 1e-6
LEAST = 1e-12
TRIALS = 12  # of dampings: the last is about 10²⁰ times the first, no step at all
FALL = 0.1
# What is added to the diagonal, damping apart, where rounding has made the matrix indefinite.
SHIFTS = (0.0, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9)


class LeastSquares(Protocol):
    """A sum of squares, by its value and its normal equations."""

    def evaluate(self, a: FloatArray) -> Evaluation:
        """Return what there is to see at a."""
        ...

    def normal_equations(self, evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
        """Return the Gauss–Newton matrix and half the negative gradient."""
        ...


@dataclass(frozen=True, eq=False)
class Refined:
    """Where the steps ended: the coefficients, what is seen there, and how many steps it took."""

    coefficients: FloatArray
    evaluation: Evaluation
    steps: int


def refine(objective: LeastSquares, a: FloatArray, steps: int, tolerance: float, patience: int) -> Refined:
    """Go down from a until `patience` steps running have gained less than this share of the value each."""
    evaluation, damping, slow, step = objective.evaluate(a), FIRST, 0, 0
    for step in range(1, steps + 1):  # noqa: B007 - the number of steps is part of the answer
        H, r = objective.normal_equations(evaluation)
        scaled, s = unit_diagonal(H)
        grow = 4.0
        for _ in range(TRIALS):
            p = s * _solved(scaled, s * r, damping)
            there = objective.evaluate(a + p)
            if there.value < evaluation.value:
                break
            damping, grow = damping * grow, grow * 2.0
        else:
            break
        gain = evaluation.value - there.value
        agreement = gain / float(p @ (2.0 * r - H @ p))
        slow = slow + 1 if gain < tolerance * evaluation.value else 0
        a, evaluation = a + p, there
        damping = max(damping * max(FALL, 1.0 - (2.0 * agreement - 1.0) ** 3), LEAST)
        if slow == patience:
            break
    return Refined(a, evaluation, step)


def solve(H: FloatArray, r: FloatArray, damping: float = 0.0) -> FloatArray:
    """Return p with (H + damping · diag H) p = r, H (m, m) symmetric and not negative.

    >>> solve(np.array([[2.0, 0.0], [0.0, 4.0]]), np.array([2.0, 2.0])).round(12).tolist()
    [1.0, 0.5]
    """
    scaled, s = unit_diagonal(H)
    return np.asarray(s * _solved(scaled, s * r, damping))


def _solved(scaled: FloatArray, r: FloatArray, damping: float) -> FloatArray:
    """Return p with (scaled + damping · 1) p = r, the diagonal being 1."""
    for shift in SHIFTS:
        A = scaled.copy()
        A.flat[:: len(A) + 1] = 1.0 + damping + shift
        # the transpose of a symmetric matrix is itself, but in the order of LAPACK, which then makes no copy
        factor, failed = lapack.dpotrf(A.T, clean=False, overwrite_a=True)
        if not failed:
            return np.asarray(lapack.dpotrs(factor, r)[0])
    raise ArithmeticError("the normal equations are not positive definite, even with a shift of 1e-9")


def unit_diagonal(H: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return S H S with S diagonal such that the diagonal is 1, and S's own (m,)."""
    s = 1.0 / np.sqrt(np.maximum(np.diag(H), np.finfo(float).tiny))
    return H * s * s[:, None], s


def condition(H: FloatArray) -> tuple[float, float]:
    """Return the estimated condition of the Jacobian with columns scaled to length 1, and max / min |r_ii| of its R."""
    scaled, _ = unit_diagonal(H)
    norm = np.abs(scaled).sum(axis=0).max()
    factor, failed = lapack.dpotrf(scaled.T, clean=False, overwrite_a=True)
    if failed:
        return float("inf"), float("inf")
    reciprocal = lapack.dpocon(factor, norm)[0]
    diagonal = np.abs(np.diag(factor)) * np.sqrt(np.diag(H))
    return float(max(reciprocal, np.finfo(float).tiny) ** -0.5), float(diagonal.max() / diagonal.min())
