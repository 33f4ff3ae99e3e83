r"""How close and how smooth a fit is, and when that is enough (the paper's section 4.2).

D_dist   = mean |f(x_i)| / ‖∇f(x_i)‖         the first-order distance of the data from the zero set, in mean radii
D_smooth = mean n_i · ∇f(x_i) / ‖∇f(x_i)‖    the cosine between the data's normals and the fit's
stop when D_dist < T₁ and D_smooth > T₂                                                                     (7)
"""

from dataclasses import dataclass

import numpy as np

from ipcore._typing import FloatArray


@dataclass(frozen=True, eq=False)
class Closeness:
    """A fit seen from its data.

    Attributes
    ----------
    distances
        (N,), |f|/‖∇f‖ at every data point, in mean radii.
    d_dist, d_smooth
        The two means above.

    """

    distances: FloatArray
    d_dist: float
    d_smooth: float

    @classmethod
    def of(cls, f: FloatArray, gradient: FloatArray, normals: FloatArray) -> "Closeness":
        """Measure from f (N,) and ∇f (N, d) in the normalised frame and unit normals (N, d).

        >>> at = Closeness.of(np.array([0.1]), np.array([[0.0, 2.0]]), np.array([[0.0, 1.0]]))
        >>> at.d_dist, at.d_smooth
        (0.05, 1.0)
        """
        size = np.maximum(np.linalg.norm(gradient, axis=1), np.finfo(float).tiny)  # a flat point is far, not undefined
        distances = np.abs(f) / size
        cosine = np.einsum("ij,ij->i", normals, gradient) / size
        return cls(distances, float(distances.mean()), float(cosine.mean()))


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
        tiny = np.finfo(float).tiny
        return max(d_dist / max(self.t1, tiny), (1.0 - d_smooth) / max(1.0 - self.t2, tiny))
