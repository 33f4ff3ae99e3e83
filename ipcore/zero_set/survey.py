"""The stray share of a zero set and its number of components, measured without making the mesh.

They are those of `zero_set` but for Newton's method, which changes the sizes of the cells by some thousandths.
"""

from ipcore._typing import FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.components import count_components
from ipcore.zero_set.grid import Grid, grid_lines
from ipcore.zero_set.marching import march_open
from ipcore.zero_set.mesh import cell_middles, labels
from ipcore.zero_set.refinement import at_resolution, refined
from ipcore.zero_set.stray import stray_cells, stray_share
from ipcore.zero_set.thickness import TOLERATED_THIN, thin_share

# Grid points along the longest axis of the bounds; a fit is checked on a grid as fine, see `geometric.exchange`.
STRAY_RESOLUTION = {2: 240, 3: 88}
# The stray share above which the zero set is wild: its thin parts and its exact number of components matter to nobody,
# and would take ten times the time.
WILD_STRAY = 0.05
# Where there is more than one component, they are counted again on a grid so many times as fine: a horse's leg hangs on
# its body by a neck that is thinner than a cell, in so few places that the grid as a whole is not too coarse.
RECOUNT = {2: 4, 3: 2}


def straying(polynomial: ImplicitPolynomial, data: FloatArray) -> tuple[float | None, int]:
    """Return the stray share of the zero set's length or area in the bounds, and its number of components there.

    The stray share is by the rule of `stray`, for data (N, d), raw, N ≥ 2; it is None if there is no zero set. Where
    the zero set is too thin for the grid, a finer one is taken, as for a mesh.

    >>> from ipcore import shapes
    >>> points, _ = shapes.ellipse().sample(500)
    >>> straying(shapes.ellipse().polynomial, points)
    (0.0, 1)
    """
    first = STRAY_RESOLUTION[polynomial.dimension]
    axes = grid_lines(polynomial, None, first)
    vertices, cells = march_open(polynomial.on_grid(axes), Grid.of(axes))
    spacing = max(float(line[1] - line[0]) for line in axes)
    stray = stray_cells(vertices, cells, data)
    share = stray_share(vertices, cells, stray)
    if share is not None and share > WILD_STRAY:
        return share, int(labels(cells, len(vertices)).max()) + 1
    resolution, places = first, cell_middles(vertices, cells[~stray])
    if share is None or thin_share(polynomial, places, spacing, polynomial.bounds) > TOLERATED_THIN:
        finer = refined(polynomial, first=2 * first, data=data)
        vertices, cells, spacing = finer.mesh.vertices, finer.mesh.cells[~finer.mesh.cap], finer.spacing
        resolution = finer.resolution
        share = stray_share(vertices, cells, stray_cells(vertices, cells, data))
    count = count_components(polynomial, vertices, cells, spacing, polynomial.bounds)
    if count > 1:
        finer = at_resolution(polynomial, None, RECOUNT[polynomial.dimension] * resolution)
        surface = finer.mesh.cells[~finer.mesh.cap]
        count = count_components(polynomial, finer.mesh.vertices, surface, finer.spacing, polynomial.bounds)
    return share, count
