"""Continuation: the homotopy in t, followed from the convex objective (t = 0) to the geometric one (t = 1).

At t = 1 the objective has many local minima, at t = 0 a single one (see `objective`). So the fit at one t is the start
at the next. The first degrees start at t = 0 from nothing (a cold start). Later degrees start from the coefficients of
the degree below, which are a prefix of theirs in the graded order (a warm start), and need not go back to t = 0.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.geometric.descent import Descent
from ipcore.geometric.levenberg_marquardt import Effort, Refined

# Tuned on the shapes of bench/QUALITY.md, see `ipcore.geometric.fit`. Without 0.7 and 0.95 after a warm start, fits
# stay in minima where gradients point against the normals: the horse then needs degree 16 or 17 in place of 14.
COLD_PATH = (0.0, 0.7, 0.95, 1.0)
WARM_PATH = (0.7, 0.95, 1.0)
COLD_DEGREES = 2  # the highest degree with a cold start
INTERMEDIATE = Effort(8, 1e-2, 1)  # at each t but the last
FINAL = Effort(40, 1e-3, 2)  # at the last t
# At the last t, and after it, the data's part of the Gauss–Newton matrix is kept for so many steps. In space this takes
# a third less time, at the same degrees or lower ones; four and five steps need higher ones, and in the plane, where a
# matrix costs little, so do two.
KEPT_STEPS = {2: 1, 3: 3}


def follow(descent: Descent, lower: FloatArray, *, geometric: bool) -> Refined:
    """Return the fit at the end of the homotopy.

    Parameters
    ----------
    descent
        The objective of the degree that is fitted; its t is set here.
    lower
        (≤ m,), the coefficients of the degree below, from which a warm start begins.
    geometric
        Whether to go to t = 1. If not, the fit is the minimum at t = 0, which needs no start.

    """
    objective = descent.objective
    cold = objective.degree <= COLD_DEGREES or not geometric
    a = np.zeros(objective.columns)
    if not cold:
        a[: len(lower)] = lower
    *intermediate, last = _path(cold=cold, geometric=geometric)
    for t in intermediate:
        objective.blend = t
        a = descent.refine(a, INTERMEDIATE).coefficients
    objective.blend = last
    objective.keep_data_matrix(KEPT_STEPS[objective.data.dimension])
    return descent.refine(a, FINAL)


def _path(*, cold: bool, geometric: bool) -> tuple[float, ...]:
    """Return the values of t, in the order in which they are taken."""
    if not geometric:
        return COLD_PATH[:1]
    return COLD_PATH if cold else WARM_PATH
