"""The time and memory that a fit will take, predicted before it runs."""

from dataclasses import dataclass
from math import comb

from ipcore.moments import Moments
from ipcore.options.choices import Factor
from ipcore.options.fit_options import FitOptions

# Multiplications and additions a second where all rows and columns are held, and where rows are factored in chunks;
# from fits of 200 to 20,000 points and degrees 7 to 30 on one core of 2.5 GHz.
SPEED, CHUNKED = 4e9, 1.5e10
# Seconds per row and moment of a fit from moments, with the look at each of its degrees.
PER_MOMENT = 6e-10
# The degrees above which the condition of moments mostly is too bad, so that rows are factored instead.
MOMENT_DEGREE = {2: 16, 3: 13}
# Seconds per coefficient, and per coefficient squared, of a geometric fit: it hardly depends on the number of points,
# from fits of 100 to 20,000 points and degrees 6 to 20.
PER_COLUMN, PER_PAIR = 6e-3, 2.5e-5
# Seconds for everything else. With these constants the prediction is within a factor of 3 of what was measured.
OVERHEAD = {2: 0.05, 3: 0.3}


@dataclass(frozen=True)
class Plan:
    """What a fit will try, hold and take.

    Attributes
    ----------
    max_degree
        The last degree that it tries.
    rows
        Equations of its linear system.
    held_bytes
        Bytes of the linear system, if it is held as a whole; else 0.
    summable
        Whether the fit can be made from moments, which add over parts of the points.
    moment_degree
        The degree up to which moments are of use to it.
    seconds
        Predicted time on one thread.

    """

    max_degree: int
    rows: int
    held_bytes: int
    summable: bool
    moment_degree: int
    seconds: float


def plan(dimension: int, points: int, options: FitOptions, *, normals: bool) -> Plan:
    """Return what a fit will take.

    Parameters
    ----------
    dimension, points
        d and N.
    options
        See `FitOptions`.
    normals
        Whether the points come with normals.

    Raises
    ------
    InvalidOptionsError
        If `max_degree` is over the highest that the dimension allows.

    Examples
    --------
    >>> block = plan(3, 20_000, FitOptions(max_degree=12, factor=Factor.BLOCK), normals=True)
    >>> block.rows, block.held_bytes // 2**20, block.summable
    (60000, 208, False)

    """
    degree = options.degree_cap(dimension)
    rows = points * options.family.rows_per_point(dimension)
    columns = min(comb(degree + dimension, dimension), points)
    held = _holds_system(options)
    return Plan(
        max_degree=degree,
        rows=rows,
        held_bytes=8 * rows * columns if held else 0,
        summable=normals and Moments.can_fit(options),
        moment_degree=min(degree, MOMENT_DEGREE[dimension]),
        seconds=_seconds(dimension, points, degree, options),
    )


def _holds_system(options: FitOptions) -> bool:
    """Return whether a fit holds all rows and columns of its linear system at once."""
    return options.is_linear and (options.factor in {Factor.BLOCK, Factor.GRAM_SCHMIDT} or options.needs_rows)


def _seconds(dimension: int, points: int, degree: int, options: FitOptions) -> float:
    columns = min(comb(degree + dimension, dimension), 3 * points)
    if options.is_linear:
        return OVERHEAD[dimension] + _of_rows(dimension, points, degree, columns, held=_holds_system(options))
    return OVERHEAD[dimension] + PER_COLUMN * columns + PER_PAIR * columns**2


def _of_rows(dimension: int, points: int, degree: int, columns: int, *, held: bool) -> float:
    factored = 6.0 * points * columns**2
    if held:
        return factored / SPEED
    moments = PER_MOMENT * 3.0 * points * comb(2 * degree + dimension, dimension)
    return moments + (factored / CHUNKED if degree > MOMENT_DEGREE[dimension] else 0.0)
