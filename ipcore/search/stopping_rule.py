r"""The paper's stopping rule, eq. (7), and how far a fit is from meeting it.

    stop when D_dist < T₁ and D_smooth > T₂                                                                     (7)

with D_dist and D_smooth as in `ipcore.search.closeness`.
"""

from dataclasses import dataclass

import numpy as np

# Where ‖∇f‖ is less than this share of its maximum over the data, |f| is divided by that share instead. Where a curve
# crosses or touches itself f and ∇f are 0 together, and |f|/‖∇f‖ is a quotient of rounding errors, which could be 1.
SHORTEST_GRADIENT = 1e-4


@dataclass(frozen=True)
class StoppingRule:
    """Eq. (7), with its two thresholds: T₁ in mean radii, T₂ a mean cosine."""

    t1: float
    t2: float

    def met(self, d_dist: float, d_smooth: float) -> bool:
        """Return whether the fit is close and smooth enough."""
        return d_dist < self.t1 and d_smooth > self.t2

    def excess(self, d_dist: float, d_smooth: float) -> float:
        """Return how far a fit is from meeting the rule: the greater of D_dist/T₁ and (1 − D_smooth)/(1 − T₂).

        It is below 1 exactly when the rule is met, so the fit with the least excess is the best one when none meets it.

        >>> StoppingRule(0.01, 0.95).excess(0.02, 0.99)
        2.0
        """
        return max(self.excesses(d_dist, d_smooth))

    def excesses(self, d_dist: float, d_smooth: float) -> tuple[float, float]:
        """Return the two quotients, D_dist/T₁ and (1 − D_smooth)/(1 − T₂)."""
        tiny = np.finfo(float).tiny
        return d_dist / max(self.t1, tiny), (1.0 - d_smooth) / max(1.0 - self.t2, tiny)
