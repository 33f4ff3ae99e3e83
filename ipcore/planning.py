r"""The time and memory that a fit will take, predicted before it runs.

The predicted time is that of a fit that goes on to its last degree n_max, on one thread: a queue plans with an upper
estimate. A fit that stops at a lower degree takes less, often much less. With d dimensions, N points and
m_n = C(n + d, d) coefficients at degree n, the time is a sum of these terms, each with a constant below:

    preparation         1, N
    normals             N, k N                                  k neighbours; if no normals are given
    geometric fit       Σ_n p_n C(2n + d, d)                    p_n points, from which degree n is fitted; robust: N
    signs only          Σ_n g_n                                 g_n nodes of the grid on which signs are constrained
    linear fit          N Σ m                                   D_dist and D_smooth at every degree, or every column
      by moments        rows · C(2n + d, d)
      by chunks of rows rows · m, rows · m²
      all rows held     rows · m, rows · m²

The sums run over n = 1 … n_max. `bench/PREDICTIONS.md` has predictions beside measured times: those of fits of noisy
points that went to their last degree are within a factor of 3, from 100 to 1,000,000 points. The constants were fitted
to half of those cases, as seconds of one core of 2.5 GHz, so that the logarithms of the ratios are small.
"""

from dataclasses import dataclass
from math import comb

from ipcore.geometric.sizes import nodes_per_axis, points_used
from ipcore.options.choices import Factor, Granularity
from ipcore.options.fit_options import FitOptions
from ipcore.polynomial import graded

# Seconds that any fit takes: by dimension, and per point.
LINEAR_BASE, GEOMETRIC_BASE = {2: 0.06, 3: 0.2}, {2: 0.24, 3: 1.0}
PREPARATION_PER_POINT = 5e-7
# Seconds per point, and per point and neighbour, for estimated normals.
NORMALS_PER_POINT, NORMALS_PER_NEIGHBOUR = {2: 1.2e-5, 3: 7.7e-6}, 4.9e-7
# Bytes that they take per point, and per point and neighbour.
NORMALS_BYTES, NEIGHBOUR_BYTES = 200, 47
# Seconds per point and moment of a geometric fit: some twenty Gauss–Newton steps at each degree.
GEOMETRIC_PER_MOMENT = {2: 9e-7, 3: 1.4e-6}
ROBUST_PER_POINT = 2.1e-5
# Seconds per node of a fit under sign constraints alone.
SIGNS_PER_NODE = {2: 4.5e-6, 3: 1.8e-6}
# Seconds per point and coefficient of D_dist and D_smooth.
CLOSENESS_PER_ENTRY = 4e-9
# Seconds per row and moment; per row and coefficient, to make the rows; per row and squared coefficient, to factor them
# in chunks, as a whole, and by eq. (5), which goes column by column.
LINEAR_PER_MOMENT = {2: 4e-9, 3: 1.2e-9}
ROWS_PER_ENTRY, CHUNK_PER_SQUARE, HELD_PER_SQUARE, COLUMNWISE_PER_SQUARE = 4e-8, 7e-11, 6e-10, 1.4e-9
# The degree up to which parts of a point set are summed: above it, the condition of moments is often too bad for them
# to be of use. On noisy points in 3D they are of use a little longer.
MOMENT_DEGREE, NOISY_MOMENT_DEGREE = {2: 16, 3: 13}, {2: 16, 3: 15}


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
    normals_bytes
        Predicted bytes that the estimation of normals takes; 0 if they are given.
    summable
        Whether the fit can be made from moments, which add over parts of the points.
    moment_degree
        The degree up to which moments are of use to it.
    seconds
        Predicted time on one thread, if it goes on to its last degree.

    """

    max_degree: int
    rows: int
    held_bytes: int
    normals_bytes: int
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
        Whether the points come with normals. Without them, points are taken to be in no order: normals of an outline
        take a quarter to a half of the time predicted for them.

    Raises
    ------
    InvalidOptionsError
        If `max_degree` is over the highest that the dimension allows.

    Examples
    --------
    >>> block = plan(3, 20_000, FitOptions(max_degree=12, factor=Factor.BLOCK), normals=True)
    >>> block.rows, block.held_bytes // 2**20, block.summable
    (60000, 208, False)
    >>> scan = plan(3, 1_000_000, FitOptions(max_degree=4, neighbours=100), normals=False)
    >>> round(scan.seconds), round(scan.normals_bytes / 1e9, 1)
    (59, 4.9)

    """
    degree = options.degree_cap(dimension)
    rows = points * options.family.rows_per_point(dimension)
    columns = min(comb(degree + dimension, dimension), points)
    seconds = PREPARATION_PER_POINT * points
    if not normals:
        seconds += points * (NORMALS_PER_POINT[dimension] + NORMALS_PER_NEIGHBOUR * options.neighbours)
    last = graded.highest_determined(dimension, points, degree)
    seconds += (_linear if options.is_linear else _geometric)(dimension, points, last, options)
    return Plan(
        max_degree=degree,
        rows=rows,
        held_bytes=8 * rows * columns if _holds_system(options) else 0,
        normals_bytes=0 if normals else points * (NORMALS_BYTES + NEIGHBOUR_BYTES * options.neighbours),
        summable=normals and options.fits_from_moments,
        moment_degree=min(degree, MOMENT_DEGREE[dimension]),
        seconds=seconds,
    )


def _holds_system(options: FitOptions) -> bool:
    """Return whether a fit holds all rows and columns of its linear system at once."""
    return options.is_linear and (options.factor in {Factor.BLOCK, Factor.GRAM_SCHMIDT} or options.needs_rows)


def _geometric(d: int, points: int, last: int, options: FitOptions) -> float:
    """Return the seconds of a geometric fit, or one under sign constraints alone, without its preparation."""
    seconds = GEOMETRIC_BASE[d] + (ROBUST_PER_POINT * points if options.robust else 0.0)
    degrees = range(1, last + 1)
    if not options.on_geometric:
        nodes = sum(float(nodes_per_axis(d, n)) ** d for n in degrees)
        return seconds + SIGNS_PER_NODE[d] * nodes
    used = [min(points, points_used(d, n)) for n in degrees]
    return seconds + GEOMETRIC_PER_MOMENT[d] * sum(p * comb(2 * n + d, d) for n, p in zip(degrees, used, strict=True))


def _linear(d: int, points: int, last: int, options: FitOptions) -> float:
    """Return the seconds of a linear fit without its preparation."""
    rows, columns = points * options.family.rows_per_point(d), comb(last + d, d)
    by_column = options.granularity is Granularity.MONOMIAL
    tested = columns**2 / 2.0 if by_column else sum(comb(n + d, d) for n in range(1, last + 1))
    seconds = LINEAR_BASE[d] + CLOSENESS_PER_ENTRY * points * tested
    if _holds_system(options):
        eq5 = options.factor is Factor.GRAM_SCHMIDT
        per_square = COLUMNWISE_PER_SQUARE if eq5 else HELD_PER_SQUARE
        return seconds + rows * (ROWS_PER_ENTRY * columns + per_square * columns**2)
    moments = bool(options.layer_offsets) and options.factor is not Factor.TSQR
    if moments:
        seconds += LINEAR_PER_MOMENT[d] * rows * comb(2 * min(last, NOISY_MOMENT_DEGREE[d]) + d, d)
    if not moments or last > NOISY_MOMENT_DEGREE[d]:
        seconds += rows * (ROWS_PER_ENTRY * columns + CHUNK_PER_SQUARE * columns**2)
    return seconds
