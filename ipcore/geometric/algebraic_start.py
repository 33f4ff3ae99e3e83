r"""The algebraic fit: a fit that is exact where the points lie on an algebraic curve or surface of this degree.

The minimum of Σ f² / Σ ‖∇f‖² over the points (Taubin, PAMI 1991) is an eigenvalue problem. So it needs no start and
does not care how the shape lies, and if a polynomial vanishes on all points it is found to rounding. The homotopy,
which follows the normals, may end elsewhere, beside points where f and ∇f vanish together or on a thin shape. On points
of a shape that is not algebraic, or with noise, Taubin's fit is no better than that of the homotopy, and grows stray
sheets; so it is taken only where it is exact.
"""

import numpy as np

from ipcore._typing import FloatArray
from ipcore.geometric.descent import Descent
from ipcore.geometric.levenberg_marquardt import Refined

# The highest degree at which it is tried: unions of three conics or quadrics. Above, few noise-free shapes are met.
HIGHEST_EXACT_DEGREE = 6
# It is taken if its D_dist is so many times less than that of the homotopy, and than t1. On 28 real sets the least
# quotient was 0.6, on noise-free algebraic shapes the largest 1e-3.
EXACTNESS = 0.01
MOST_POINTS = 2000  # from which it is computed, evenly spaced among all; it is compared at all
# Factors of f of which the best is taken. At the tips of a needle ∇f is much shorter than on its sides, so that f, of
# slope 1 on average, does not reach the margins of the sign constraints there.
SLOPES = (1.0, 10.0, 100.0, 1000.0)
# Directions of the coefficients in which f and ∇f vanish on all points, against the largest singular value.
RANK_TOLERANCE = 1e-13


def exact_or(descent: Descent, fit: Refined) -> Refined:
    """Return the algebraic fit if it is exact, else the given one.

    It is not refined: where f reaches the margins of the sign constraints with another scale only, or does not reach
    them, as at the tips of a needle, refining would trade exactness for them.

    `descent` is the objective of the degree, at t = 1.
    """
    objective = descent.objective
    limit = EXACTNESS * min(objective.closeness(fit.evaluation)[0], descent.rule.t1)
    if objective.degree > HIGHEST_EXACT_DEGREE or limit == 0.0:
        return fit
    try:
        a = algebraic_fit(*objective.rows(MOST_POINTS))
    except np.linalg.LinAlgError:  # the iteration for singular values did not converge
        return fit
    if a is None or objective.closeness(objective.evaluate(a))[0] > limit:
        return fit
    scaled = [(s * a, objective.evaluate(s * a)) for s in SLOPES]
    return Refined(*min(scaled, key=lambda one: one[1].value), steps=0)


def algebraic_fit(rows: FloatArray, normals: FloatArray) -> FloatArray | None:
    """Return the coefficients (m,) that minimise Σ f² / Σ ‖∇f‖², with mean ‖∇f‖² = 1 and ∇f along the normals.

    Return None if every polynomial that vanishes on the points vanishes there with its gradient.

    Parameters
    ----------
    rows
        (1 + d, N, m), the basis functions and their partial derivatives at the points.
    normals
        (d, N), unit, outward.

    """
    values, gradients = rows[0], rows[1:].reshape(-1, rows.shape[2])
    scale = np.linalg.norm(np.vstack([values, gradients]), axis=0)
    scale[scale == 0.0] = 1.0
    _, size, V = np.linalg.svd(np.linalg.qr(gradients / scale, mode="r"), full_matrices=False)
    kept = size > RANK_TOLERANCE * size[0]
    directions = (V[kept] / size[kept, None]).T / scale[:, None]  # (m, k), with Σ ‖∇f‖² = 1 and 0 between two of them
    constant = np.zeros(len(scale))
    constant[0] = 1.0
    # the constant has no gradient: for each direction it takes the value that makes Σ f² least
    directions = directions - constant[:, None] * (values @ directions).mean(axis=0) / values[0, 0]
    a = directions @ np.linalg.svd(values @ directions, full_matrices=False)[2][-1]
    gradient = rows[1:] @ a
    length = float(np.sqrt((gradient**2).sum() / gradient.shape[1]))
    if not length > 0.0:
        return None
    return np.asarray(a / (length if (gradient * normals).sum() >= 0.0 else -length))
