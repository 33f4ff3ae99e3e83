"""How many points and how many nodes of a grid the geometric fit of a degree uses; `ipcore.planning` counts on it."""

from ipcore.polynomial import graded

NODES_PER_DEGREE = {2: 10, 3: 6}  # along each axis
FEWEST_NODES, NODES_STEP = 33, 16  # along each axis: the least number, and its increments, so that few grids are made
# The number of points from which a degree is fitted first: per coefficient, and at least.
POINTS_PER_COLUMN, FEWEST_POINTS = 6, 2000


def points_used(dimension: int, degree: int) -> int:
    """Return from how many points a degree is fitted first, if there are as many.

    >>> points_used(2, 4), points_used(3, 12)
    (2000, 2730)
    """
    return max(FEWEST_POINTS, POINTS_PER_COLUMN * graded.count(dimension, degree))


def nodes_per_axis(dimension: int, degree: int) -> int:
    """Return along how many nodes of each axis the signs of a degree are constrained.

    >>> nodes_per_axis(2, 2), nodes_per_axis(3, 12)
    (33, 81)
    """
    return max(FEWEST_NODES, 1 + NODES_STEP * -(-NODES_PER_DEGREE[dimension] * degree // NODES_STEP))
