r"""How close and how smooth a fit is, and when that is enough (the paper's section 4.2).

D_dist   = mean |f(x_i)| / ‖∇f(x_i)‖         the first-order distance of the data from the zero set, in mean radii
D_smooth = mean n_i · ∇f(x_i) / ‖∇f(x_i)‖    the cosine between the data's normals and the fit's
stop when D_dist < T₁ and D_smooth > T₂                                                                     (7)

On noisy data D_dist stays near the noise and the rule may never be met. What then tells the right degree comes almost
free from the factorisation: three estimates of the error at points that were not fitted, each with a minimum.

GCV = n · RSS / (n − k)²              Golub, Heath and Wahba 1979; n rows, k degrees of freedom
BIC = n ln(RSS / n) + k ln n          Schwarz 1978
LOO = mean ‖(I − H_ii)⁻¹ r_i‖² / r    r_i the residuals of the r rows of point i, left out together; H = Q Qᵀ
"""

from dataclasses import dataclass

import numpy as np

from ipcore._typing import FloatArray


@dataclass(frozen=True, eq=False)
class Closeness:
    """A fit seen from its data.

    Attributes
    ----------
    d_dist, d_smooth
        The two means above.
    farthest
        The maximum of |f|/‖∇f‖, in mean radii.

    """

    d_dist: float
    d_smooth: float
    farthest: float


def distances_and_cosines(f: FloatArray, gradient: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return |f|/‖∇f‖ and n·∇f/‖∇f‖, (N,) each, from f (N,) and ∇f (N, d) in the normalised frame and unit normals.

    >>> at = distances_and_cosines(np.array([0.1]), np.array([[0.0, 2.0]]), np.array([[0.0, 1.0]]))
    >>> [values.tolist() for values in at]
    [[0.05], [1.0]]
    """
    size = np.maximum(np.linalg.norm(gradient, axis=1), np.finfo(float).tiny)  # a flat point is far, not undefined
    return np.abs(f) / size, np.einsum("ij,ij->i", normals, gradient) / size


@dataclass(frozen=True)
class StoppingRule:
    """Eq. (7), with its two thresholds."""

    t1: float
    t2: float

    def met(self, d_dist: float, d_smooth: float) -> bool:
        """Return whether the fit is close and smooth enough."""
        return d_dist < self.t1 and d_smooth > self.t2

    def excess(self, d_dist: float, d_smooth: float) -> float:
        """Return how far a fit is from meeting the rule: the worse of D_dist/T₁ and (1 − D_smooth)/(1 − T₂).

        Below 1 exactly when the rule is met, so the fit with the least excess is the best one when none meets it.

        >>> StoppingRule(0.01, 0.95).excess(0.02, 0.99)
        2.0
        """
        return max(self.excesses(d_dist, d_smooth))

    def excesses(self, d_dist: float, d_smooth: float) -> tuple[float, float]:
        """Return the two quotients."""
        tiny = np.finfo(float).tiny
        return d_dist / max(self.t1, tiny), (1.0 - d_smooth) / max(1.0 - self.t2, tiny)


def gcv(rows: int, freedom: float, rss: float) -> float:
    """Return generalised cross-validation; infinite where the fit interpolates.

    >>> gcv(10, 5.0, 1.0)
    0.4
    """
    free = rows - freedom
    return rows * rss / free**2 if free > 0.0 else float("inf")


def bic(rows: int, freedom: float, rss: float) -> float:
    """Return Schwarz' criterion, up to a constant.

    It asks for a simpler fit than the other two. The rows of one point are counted as independent, which they are not:
    with points for rows it stopped far too early, on outlines with noise 0.02 at up to twice the error.

    >>> bic(300, 0.0, 300.0)
    0.0
    """
    return float(rows * np.log(max(rss / rows, np.finfo(float).tiny)) + freedom * np.log(rows))


class Leverage:
    """What every point has to say in its own fit: the blocks H_ii (r, r) of H = Q Qᵀ, grown column by column."""

    def __init__(self, groups: int, points: int) -> None:
        """Start without columns, for `groups` rows per point."""
        self.columns = 0
        self._H = np.zeros((points, groups, groups))

    def add(self, blocks: list[FloatArray]) -> None:
        """Add columns of Q, in blocks (rows, …) whose rows stand group by group."""
        points, groups = self._H.shape[:2]
        for block in blocks:
            Q = block.reshape(groups, points, -1)
            self._H += np.einsum("ipk,jpk->pij", Q, Q, optimize=True)
            self.columns += block.shape[1]

    def left_out(self, residual: FloatArray) -> float:
        """Return the mean squared error (per row) at points left out one by one, from the residual (rows,) of the fit.

        No fit is made again: leaving rows out turns their residuals r_i into (I − H_ii)⁻¹ r_i. A point without which
        the fit is not determined makes it infinite.
        """
        points, groups = self._H.shape[:2]
        r = residual.reshape(groups, points).T[:, :, None]
        try:
            errors = np.linalg.solve(np.eye(groups) - self._H, r)
        except np.linalg.LinAlgError:
            return float("inf")
        return float((errors**2).mean())
