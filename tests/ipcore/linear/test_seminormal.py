"""Corrections by R scaled with s: each takes 1/s² of the step to the solution, so errors shrink by |1 − 1/s²|."""

import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.linear.layer_moments import LayerMoments
from ipcore.linear.qr.r_factor import RFactor
from ipcore.linear.row_source import MomentRows
from ipcore.linear.seminormal import MAX_CORRECTIONS, Refinement, refine

EPS = np.finfo(float).eps


class DenseRows:
    """All rows of a random system."""

    max_condition = np.inf

    def __init__(self) -> None:
        generator = np.random.default_rng(0)
        self.M, self.b = generator.normal(size=(60, 6)), generator.normal(size=60)
        self.passes = 0

    def from_moments(self, degree: int) -> RFactor:
        raise NotImplementedError

    def from_rows(self, degree: int) -> RFactor:
        raise NotImplementedError

    def normal_residuals(
        self,
        degree: int,  # noqa: ARG002 - all rows have the same degree
        A: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        self.passes += 1
        residuals = self.b[:, None] - self.M @ A
        return self.M.T @ residuals, (residuals**2).sum(axis=0)


def refinement(rows: DenseRows, step: float, used: list[int]) -> Refinement:
    """Return a fit that starts at 0, with R such that every correction takes this part of the step."""
    R = np.linalg.qr(rows.M[:, used])[1] / np.sqrt(step)
    return Refinement(R, np.array(used), np.zeros(len(used)))


@pytest.mark.parametrize(
    ("step", "converged"),
    [
        (1.0, True),
        (0.95, True),  # errors shrink to a twentieth each time
        (1.05, True),
        (0.55, False),  # to 0.45: fast enough to go on, but not done after all corrections
        (0.4, False),  # to 0.6: given up at once
        (1.6, False),
        (2.5, False),  # they grow
    ],
)
def test_corrections_converge_or_are_given_up(*, step: float, converged: bool) -> None:
    rows = DenseRows()
    fit = refinement(rows, step, list(range(6)))
    refine([fit], rows, 1, 6)
    assert fit.converged is converged
    a, rss, _, _ = np.linalg.lstsq(rows.M, rows.b)
    if converged:
        np.testing.assert_allclose(fit.a, a, atol=1e-6)
        assert fit.rss == pytest.approx(rss[0], rel=1e-8)


def test_slow_convergence_is_given_up_after_two_corrections_and_fast_after_all() -> None:
    for step, passes in ((0.4, 2), (0.55, MAX_CORRECTIONS), (1.0, 2)):
        rows = DenseRows()
        refine([refinement(rows, step, list(range(6)))], rows, 1, 6)
        assert rows.passes == passes


def test_fits_with_different_columns_are_corrected_in_the_same_passes() -> None:
    rows = DenseRows()
    fits = [refinement(rows, 1.0, used) for used in ([0, 1, 2], [0, 2, 3, 5])]
    refine(fits, rows, 1, 6)
    assert rows.passes == 2
    for fit in fits:
        np.testing.assert_allclose(fit.a, np.linalg.lstsq(rows.M[:, fit.used], rows.b)[0], atol=100 * EPS)


def test_without_rows_nothing_is_corrected() -> None:
    fit = refinement(DenseRows(), 1.0, [0, 1])
    refine([fit], MomentRows(LayerMoments.empty(2, 2, (0.0,))), 1, 6)
    assert fit.converged is None
    np.testing.assert_array_equal(fit.a, np.zeros(2))
