r"""Least squares from a triangle that is not quite right, refined on the rows themselves, all degrees at once.

Where R comes from MᵀM, it is off by about κ² · 1e-16, and so is its solution. Corrected semi-normal equations (Björck
1987) gain the inverse of that factor each time, as long as it is less than 1:

    a ← a + R⁻¹ R⁻ᵀ Mᵀ (b − M a)

The fits of several degrees take one pass over the rows together: their residuals share the tables of the variables, and
Mᵀ times all of them is one pass of first moments.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ipcore._typing import FloatArray, IntArray
from ipcore.linear.row_source import RowSource

# A correction that moves f by a share ε of the residual was followed by one of 7 to 35 ε², on four surfaces at degrees
# 12 and 13. So one that moves it by less than this is the last, and leaves 1e-8 of the residual, or 1e-9 of D_dist.
ENOUGH = 2e-5
SLOW, MOST = 0.5, 6  # a correction that moves f by more than this share of what the one before did is given up


@dataclass(eq=False)
class Refinement:
    """The fit with a prefix of columns while it is refined.

    Attributes
    ----------
    R
        (k, k), of the columns in use.
    used
        (k,), which columns they are.
    a
        (k,), their coefficients.
    rss
        ‖M a − b‖².
    settled
        True once f stands still, False if it does not, None meanwhile.

    """

    R: FloatArray
    used: IntArray
    a: FloatArray
    rss: float = 0.0
    settled: bool | None = None
    _gained: float = np.inf

    def correct(self, g: FloatArray, rss: float) -> None:
        """Take one step, given Mᵀ(b − M a) of the columns in use and ‖M a − b‖²."""
        y = solve_triangular(self.R, g, trans="T", check_finite=False)
        self.a = self.a + solve_triangular(self.R, y, check_finite=False)
        gained = float(y @ y)
        self.rss = max(rss - gained, 0.0)
        if gained <= ENOUGH**2 * rss:
            self.settled = True
        elif gained > SLOW**2 * self._gained:
            self.settled = False
        self._gained = gained


def refine(fits: list[Refinement], source: RowSource, degree: int, columns: int) -> None:
    """Refine fits of degrees up to `degree`, with so many columns, until each has settled one way or the other."""
    for _ in range(MOST):
        moving = [fit for fit in fits if fit.settled is None]
        if not moving:
            return
        A = np.zeros((columns, len(moving)))
        for a, fit in zip(A.T, moving, strict=True):
            a[fit.used] = fit.a
        seen = source.gradients(degree, A)
        if seen is None:  # only moments are left, which were good enough to begin with
            return
        for fit, g, rss in zip(moving, seen[0].T, seen[1], strict=True):
            fit.correct(g[fit.used], float(rss))
    for fit in fits:
        fit.settled = fit.settled is True
