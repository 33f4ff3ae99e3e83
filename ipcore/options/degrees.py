"""The degrees that can be tried, by dimension."""

from ipcore.errors import InvalidOptionsError

# The last degree to try if none is given: 231 coefficients in 2D, 969 in 3D.
DEFAULT_MAX_DEGREE = {2: 20, 3: 16}
# The highest degree that can be given: 861 and 1,771 coefficients.
HIGHEST_DEGREE = {2: 40, 3: 20}


def last_degree(max_degree: int | None, dimension: int) -> int:
    """Return the last degree to try on points of this dimension: `max_degree`, or the default if it is None.

    Raises
    ------
    InvalidOptionsError
        If `max_degree` is over the highest that the dimension allows.

    """
    degree, highest = DEFAULT_MAX_DEGREE[dimension] if max_degree is None else max_degree, HIGHEST_DEGREE[dimension]
    if degree > highest:
        raise InvalidOptionsError(
            f"max_degree must be at most {highest} for {dimension}D points, not {degree}", ("max_degree",)
        )
    return degree
