r"""Leave-one-out errors of a linear least-squares fit, from its factorisation M = QR.

LOO = mean ‖(I − H_ii)⁻¹ r_i‖² / r    r_i the residuals of the r rows of point i, left out together; H = Q Qᵀ
"""

import numpy as np

from ipcore._typing import FloatArray


class Leverage:
    """The leverage of every point on its own fit: the blocks H_ii (r, r) of H = Q Qᵀ, summed column by column.

    Attributes
    ----------
    columns
        How many columns of Q were added so far.

    """

    def __init__(self, rows_per_point: int, points: int) -> None:
        """Start without columns."""
        self.columns = 0
        self._H = np.zeros((points, rows_per_point, rows_per_point))

    def add(self, blocks: list[FloatArray]) -> None:
        """Add columns of Q, in blocks (rows, …) whose rows stand group by group, one row per point in each group."""
        points, groups = self._H.shape[:2]
        for block in blocks:
            Q = block.reshape(groups, points, -1)
            self._H += np.einsum("ipk,jpk->pij", Q, Q, optimize=True)
            self.columns += block.shape[1]

    def leave_one_out_error(self, residual: FloatArray) -> float:
        """Return the mean squared error per row at points left out one by one, from the residual (rows,) of the fit.

        No fit is made again: leaving the rows of point i out turns their residuals r_i into (I − H_ii)⁻¹ r_i. The error
        is infinite if the fit is not determined without some point.
        """
        points, groups = self._H.shape[:2]
        r = residual.reshape(groups, points).T[:, :, None]
        try:
            errors = np.linalg.solve(np.eye(groups) - self._H, r)
        except np.linalg.LinAlgError:
            return float("inf")
        return float((errors**2).mean())
