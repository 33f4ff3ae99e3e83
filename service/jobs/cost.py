"""How long a fit will take, predicted before it runs."""

from math import comb
from typing import Any

# What the library tries when no max_degree is given.
DEFAULT_MAX_DEGREE = {2: 20, 3: 16}
# Options that only a linear fit has, and criteria.
LINEAR = {"preset", "constraints", "granularity", "factor", "collinear", "ridge"}
LINEAR_CRITERIA = {"gcv", "bic", "loo"}
# Multiplications and additions a second of a linear fit, from fits of 200 to 20,000 points and degrees 7 to 30 on one
# core of 2.5 GHz.
SPEED = 4e9
# Seconds per coefficient, and per coefficient squared, of a geometric fit: it hardly depends on the number of points,
# from fits of 100 to 20,000 points and degrees 6 to 20.
PER_COLUMN, PER_PAIR = 6e-3, 2.5e-5
# Seconds for everything else. With these constants the prediction is within a factor of 3 of what was measured.
OVERHEAD = {2: 0.05, 3: 0.3}
# Predicted seconds up to which a fit is short.
SHORT = 5.0


def predicted_seconds(dimension: int, points: int, options: dict[str, Any]) -> float:
    """Return the predicted time of a fit that goes on to its last degree, in seconds.

    That of a linear fit goes into factorising 3N rows and m = (degree + d choose d) columns, 6 N m² operations;
    that of a geometric fit into some twenty steps at each degree, each with moments and an m × m system.

    >>> f"{predicted_seconds(3, 20_000, {'max_degree': 12, 'geometric': False}):.1f}"
    '6.5'
    >>> f"{predicted_seconds(3, 20_000, {'max_degree': 12}):.1f}"
    '8.2'
    """
    degree = options.get("max_degree") or DEFAULT_MAX_DEGREE[dimension]
    columns = min(comb(degree + dimension, dimension), 3 * points)
    if _linear(options):
        return OVERHEAD[dimension] + 6.0 * points * columns**2 / SPEED
    return OVERHEAD[dimension] + PER_COLUMN * columns + PER_PAIR * columns**2


def _linear(options: dict[str, Any]) -> bool:
    asked = options.get("geometric") is False and not options.get("signs")
    return asked or bool(LINEAR & options.keys()) or options.get("criterion") in LINEAR_CRITERIA
