"""How long a fit will take, predicted before it runs."""

from math import comb
from typing import Any

# What the library tries when no max_degree is given.
DEFAULT_MAX_DEGREE = {2: 20, 3: 16}
# Multiplications and additions a second, and seconds for everything else, from fits of 200 to 20,000 points and degrees
# 7 to 30 on one core of 2.5 GHz; with them the prediction is within a factor of 3 of what was measured.
SPEED = 4e9
OVERHEAD = {2: 0.05, 3: 0.3}
# Predicted seconds up to which a fit is short.
SHORT = 5.0


def predicted_seconds(dimension: int, points: int, options: dict[str, Any]) -> float:
    """Return the predicted time of a fit that goes on to its last degree, in seconds.

    The time goes into the factorisation of 3N rows and m = (degree + d choose d) columns, 6 N m² operations.

    >>> f"{predicted_seconds(3, 20_000, {'max_degree': 12}):.1f}"
    '6.5'
    """
    degree = options.get("max_degree") or DEFAULT_MAX_DEGREE[dimension]
    columns = min(comb(degree + dimension, dimension), 3 * points)
    return OVERHEAD[dimension] + 6.0 * points * columns**2 / SPEED
