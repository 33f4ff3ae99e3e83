r"""Corrected semi-normal equations: least squares with an inexact R, corrected by the rows, for many degrees at once.

If R comes from MᵀM, its relative error is about κ² · 1e-16, and so is that of its solution. Corrected semi-normal
equations (Björck 1987) reduce the error by about that factor in each step, as long as the factor is less than 1:

    a ← a + R⁻¹ R⁻ᵀ Mᵀ (b − M a)

The fits of several degrees are corrected in one pass over the rows: their residuals share the tables of the variables,
and Mᵀ times all residuals is one pass of first moments.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ipcore._typing import FloatArray, IntArray
from ipcore.linear.row_source import RowSource

# A correction that changes f by a share ε of the residual was followed by one of 7 to 35 ε², on four surfaces at
# degrees 12 and 13. So one that changes it by less than this is the last: the error left is 1e-8 of the residual, or
# 1e-9 of D_dist.
LAST_CORRECTION = 2e-5
# A correction that changes f by more than this share of what the one before did does not converge: it is given up.
SLOWEST_CONVERGENCE = 0.5
# Corrections at most: at the slowest convergence that is accepted, six reduce the error by 64.
MAX_CORRECTIONS = 6


@dataclass(eq=False)
class Refinement:
    """One fit with a prefix of the columns, while it is corrected.

    Attributes
    ----------
    R
        (k, k), the factor of the columns in use.
    used
        (k,), the numbers of these columns.
    a
        (k,), their coefficients.
    rss
        ‖M a − b‖².
    converged
        True once corrections no longer change f, False if they do not converge, None before that is known.

    """

    R: FloatArray
    used: IntArray
    a: FloatArray
    rss: float = 0.0
    converged: bool | None = None
    _change: float = np.inf  # of f by the last correction, squared: ‖M Δa‖²

    def correct(self, g: FloatArray, rss: float) -> None:
        """Take one step, given g = Mᵀ(b − M a) (k,) of the columns in use and ‖M a − b‖² before the step."""
        y = solve_triangular(self.R, g, trans="T", check_finite=False)
        self.a = self.a + solve_triangular(self.R, y, check_finite=False)
        change = float(y @ y)
        self.rss = max(rss - change, 0.0)
        if change <= LAST_CORRECTION**2 * rss:
            self.converged = True
        elif change > SLOWEST_CONVERGENCE**2 * self._change:
            self.converged = False
        self._change = change


def refine(fits: list[Refinement], source: RowSource, degree: int, columns: int) -> None:
    """Correct fits of degrees up to `degree`, of at most `columns` columns, until each has converged or cannot.

    Without rows (see `RowSource`) nothing is corrected, and `converged` stays None.
    """
    for _ in range(MAX_CORRECTIONS):
        active = [fit for fit in fits if fit.converged is None]
        if not active:
            return
        A = np.zeros((columns, len(active)))
        for a, fit in zip(A.T, active, strict=True):
            a[fit.used] = fit.a
        residuals = source.normal_residuals(degree, A)
        if residuals is None:  # the limit on the condition of moments alone ensures that the fits are good enough
            return
        for fit, g, rss in zip(active, residuals[0].T, residuals[1], strict=True):
            fit.correct(g[fit.used], float(rss))
    for fit in fits:
        fit.converged = fit.converged is True
