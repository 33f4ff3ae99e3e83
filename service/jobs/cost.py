"""How long a fit will take, predicted before it runs."""

from math import comb
from typing import Any

# What the library tries when no max_degree is given.
DEFAULT_MAX_DEGREE = {2: 20, 3: 16}
# Options that only a linear fit has, and criteria.
LINEAR = {"preset", "constraints", "granularity", "factor", "collinear", "ridge"}
LINEAR_CRITERIA = {"gcv", "bic", "loo"}
# Options that make a linear fit hold all of its rows and columns.
HELD_FACTORS, HELD_CONSTRAINTS = {"block", "gram-schmidt"}, {"min-max", "min-var", "taubin"}
# Multiplications and additions a second where all rows and columns are held, and where rows are factored in chunks;
# from fits of 200 to 20,000 points and degrees 7 to 30 on one core of 2.5 GHz.
SPEED, CHUNKED = 4e9, 1.5e10
# Seconds per row and moment of a fit from moments, with the look at each of its degrees; and the degrees above which
# their condition mostly is too bad, so that rows are factored instead.
PER_MOMENT, WORN = 6e-10, {2: 16, 3: 13}
# Seconds per coefficient, and per coefficient squared, of a geometric fit: it hardly depends on the number of points,
# from fits of 100 to 20,000 points and degrees 6 to 20.
PER_COLUMN, PER_PAIR = 6e-3, 2.5e-5
# Seconds for everything else. With these constants the prediction is within a factor of 3 of what was measured.
OVERHEAD = {2: 0.05, 3: 0.3}
# Predicted seconds up to which a fit is short.
SHORT = 5.0


def predicted_seconds(dimension: int, points: int, options: dict[str, Any]) -> float:
    """Return the predicted time of a fit that goes on to its last degree, in seconds.

    That of a linear fit goes into (2 degree + d choose d) moments of 3N rows, or where these will not do, or all rows
    are held, into factorising 3N rows and m = (degree + d choose d) columns, 6 N m² operations; that of a geometric fit
    into some twenty steps at each degree, each with moments and an m × m system.

    >>> f"{predicted_seconds(3, 20_000, {'max_degree': 12, 'factor': 'block'}):.1f}"
    '6.5'
    >>> f"{predicted_seconds(3, 20_000, {'max_degree': 12, 'geometric': False}):.1f}"
    '0.4'
    >>> f"{predicted_seconds(3, 20_000, {'max_degree': 12}):.1f}"
    '8.2'
    """
    degree = options.get("max_degree") or DEFAULT_MAX_DEGREE[dimension]
    columns = min(comb(degree + dimension, dimension), 3 * points)
    if _linear(options):
        return OVERHEAD[dimension] + _of_rows(dimension, points, degree, columns, held=holds_system(options))
    return OVERHEAD[dimension] + PER_COLUMN * columns + PER_PAIR * columns**2


def rows_per_point(constraints: str, dimension: int) -> int:
    """Return how many equations a family of constraints has per point: layers, and components of the gradient.

    >>> rows_per_point("3l+gradient", 3)
    6
    """
    layers = {"3l": 3, "5l": 5, "3l+gradient": 3}.get(constraints, 1)
    return layers if constraints in {"3l", "5l"} else layers + dimension


def holds_system(options: dict[str, Any]) -> bool:
    """Return whether a fit holds all rows and columns of its linear system at once.

    >>> holds_system({"criterion": "loo"}), holds_system({"geometric": False}), holds_system({})
    (True, False, False)
    """
    return (
        options.get("factor") in HELD_FACTORS
        or options.get("preset") == "paper"
        or options.get("criterion") == "loo"
        or options.get("constraints") in HELD_CONSTRAINTS
    )


def _of_rows(dimension: int, points: int, degree: int, columns: int, *, held: bool) -> float:
    factored = 6.0 * points * columns**2
    if held:
        return factored / SPEED
    moments = PER_MOMENT * 3.0 * points * comb(2 * degree + dimension, dimension)
    return moments + (factored / CHUNKED if degree > WORN[dimension] else 0.0)


def _linear(options: dict[str, Any]) -> bool:
    asked = options.get("geometric") is False and not options.get("signs")
    return asked or bool(LINEAR & options.keys()) or options.get("criterion") in LINEAR_CRITERIA
