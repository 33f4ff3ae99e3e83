"""The weight λ of the angles, balanced against the distances so that both halves of the stopping rule are met."""

import numpy as np

from ipcore.geometric.descent import AFTER_A_CHANGE, Descent
from ipcore.geometric.levenberg_marquardt import Refined

# Tuned on the shapes of bench/QUALITY.md, see `ipcore.geometric.fit`.
BALANCE_ROUNDS = 3
# While one half of the rule is met and the other is not, λ is multiplied by
# (excess of D_smooth / excess of D_dist)^BALANCE_POWER; the quotient, and λ against the given one, change by
# BALANCE_RANGE at most.
BALANCE_POWER, BALANCE_RANGE = 1.5, 100.0
HOPELESS_PRODUCT = 1.3  # of the two excesses: above it no λ meets both halves


def balance(descent: Descent, fit: Refined, given: float) -> Refined:
    """Return the fit with the least excess while λ is moved, and leave that λ in the objective; `given` is the first λ.

    Nothing is moved if both halves of the rule are met, or if their excesses are too large to be traded.
    """
    objective = descent.objective
    best, best_weight = fit, objective.angle_weight
    for _ in range(BALANCE_ROUNDS):
        far, turned = descent.excesses(fit)
        if max(far, turned) < 1.0 or min(far, turned) > HOPELESS_PRODUCT / max(far, turned):
            break
        quotient = float(np.clip(turned / max(far, 1.0 / BALANCE_RANGE), 1.0 / BALANCE_RANGE, BALANCE_RANGE))
        moved = objective.angle_weight * quotient**BALANCE_POWER
        objective.angle_weight = min(max(moved, given / BALANCE_RANGE), given * BALANCE_RANGE)
        fit = descent.refine(fit.coefficients, AFTER_A_CHANGE)
        if descent.excess(fit) >= descent.excess(best):
            break
        best, best_weight = fit, objective.angle_weight
    objective.angle_weight = best_weight
    return best
