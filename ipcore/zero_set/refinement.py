"""The cells of f = 0 on a grid that is as fine as the zero set is thin.

Where no resolution is asked for, it is doubled until the zero set is thin in few places only. This costs little: thin
shapes have few cells, and blocks without any are not evaluated.
"""

from dataclasses import dataclass, replace

import numpy as np

from ipcore._typing import FloatArray
from ipcore.errors import InvalidOptionsError
from ipcore.polynomial import bernstein
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.extraction import extract, extract_pruned
from ipcore.zero_set.grid import DEFAULT_RESOLUTION, grid_lines
from ipcore.zero_set.mesh import Mesh, cell_middles
from ipcore.zero_set.thickness import PLACES, THIN_CELLS, TOLERATED_THIN, thin_share

DENSE_NODES = 1 << 21  # up to so many nodes, to evaluate all of them takes no longer than to find those that matter
FINEST_RESOLUTION = {2: 8192, 3: 1536}  # that is chosen: an ellipse of 500 : 1 is resolved, an ellipsoid of 200 : 1 : 1
MOST_CELLS = 600_000  # expected on a finer grid, above which it is not tried: at degree 12, some 2 s
SIGN_BLOCKS = 8  # along each axis, on which the sign of f is bounded where a grid finds no zero set


@dataclass(frozen=True, eq=False)
class Extracted:
    """The cells of f = 0 on a grid.

    Attributes
    ----------
    mesh
        Closed along the walls of the box; its vertices lie within a grid cell of f = 0.
    lines
        The grid lines of each axis, raw, (N_axis,) each.
    thin
        The share of thin places on the zero set, see `thickness`; 1 if only a finer grid has cells, None if none has.

    """

    mesh: Mesh
    lines: list[FloatArray]
    thin: float | None

    @property
    def resolution(self) -> int:
        """Return the number of grid lines along the longest axis."""
        return max(len(line) for line in self.lines)

    @property
    def spacing(self) -> float:
        """Return the longest side of a grid cell, raw."""
        return max(float(line[1] - line[0]) for line in self.lines)

    @property
    def box(self) -> FloatArray:
        """Return the corners of the box (2, d), raw."""
        return np.array([line[[0, -1]] for line in self.lines]).T

    def warning(self, *, asked: bool) -> str | None:
        """Return a sentence, in ASCII, that says that the grid is too coarse; None if it is fine enough.

        `asked` says whether the resolution was asked for.
        """
        if self.thin is None or self.thin <= TOLERATED_THIN:
            return None
        remedy = "Ask for a higher resolution or smaller bounds"
        remedy += ", or for no resolution: then it is chosen by the thickness." if asked else "."
        if self.mesh.cap.all():
            return f"The grid of resolution {self.resolution} finds no zero set, but a finer one does. {remedy}"
        return (
            f"{self.thin:.0%} of the zero set is thinner than {THIN_CELLS:.0f} cells of the grid of resolution "
            f"{self.resolution}: parts of it may be missing, in pieces or too small. {remedy}"
        )


def extracted(
    polynomial: ImplicitPolynomial,
    bounds: FloatArray | None,
    resolution: int | None,
    data: FloatArray | None,
    threads: int | None,
) -> Extracted:
    """Return the cells of f = 0 `at_resolution`, or if none is asked for, `refined`; see there."""
    if resolution is None:
        return refined(polynomial, bounds, data=data, threads=threads)
    return at_resolution(polynomial, bounds, resolution, data, threads)


def refined(
    polynomial: ImplicitPolynomial,
    bounds: FloatArray | None = None,
    first: int | None = None,
    data: FloatArray | None = None,
    threads: int | None = None,
) -> Extracted:
    """Return the cells of f = 0 on the coarsest grid on which the zero set is thin in few places only.

    If that would be too fine or have too many cells, the finest grid that is not is taken.

    Parameters
    ----------
    polynomial
        f.
    bounds
        (2, d), the corners of the box, raw; by default the polynomial's own.
    first
        Grid lines along the longest axis of the coarsest grid; default 256 in 2D, 96 in 3D. It is doubled.
    data
        (N, d), raw: the thickness beyond their support radius does not matter; None if it matters everywhere.
    threads
        How many threads work; by default all that are available.

    """
    found = _on_grid(polynomial, bounds, first or DEFAULT_RESOLUTION[polynomial.dimension], data, threads)
    while (found.thin is None or found.thin > TOLERATED_THIN) and _may_double(found, polynomial):
        found = _on_grid(polynomial, bounds, 2 * found.resolution, data, threads)
    return found


def at_resolution(
    polynomial: ImplicitPolynomial,
    bounds: FloatArray | None,
    resolution: int,
    data: FloatArray | None = None,
    threads: int | None = None,
) -> Extracted:
    """Return the cells of f = 0 at a resolution, in grid lines along the longest axis; see `refined`."""
    found = _on_grid(polynomial, bounds, resolution, data, threads)
    finer = found
    while finer.thin is None and _may_double(finer, polynomial):
        finer = _on_grid(polynomial, bounds, 2 * finer.resolution, data, threads)
    return found if finer.thin is None or found.thin is not None else replace(found, thin=1.0)


def _on_grid(
    polynomial: ImplicitPolynomial,
    bounds: FloatArray | None,
    resolution: int,
    data: FloatArray | None,
    threads: int | None,
) -> Extracted:
    """Return the cells of f = 0 at a resolution."""
    lines = grid_lines(polynomial, bounds, resolution)
    mesh = _cells(polynomial, lines, threads)
    found = Extracted(mesh, lines, None)
    surface = mesh.cells[~mesh.cap]
    if not len(surface):
        return found
    places = cell_middles(mesh.vertices, surface[:: 1 + len(surface) // PLACES])
    return replace(found, thin=thin_share(polynomial, places, found.spacing, found.box, data))


def _may_double(found: Extracted, polynomial: ImplicitPolynomial) -> bool:
    """Return whether a grid of twice the resolution may show more, and is neither too fine nor has too many cells."""
    d, cells = len(found.lines), len(found.mesh.cells)
    if 2 * found.resolution > FINEST_RESOLUTION[d] or 2 ** (d - 1) * cells > MOST_CELLS:
        return False
    return found.thin is not None or _may_vanish(polynomial, found.box)


def _may_vanish(polynomial: ImplicitPolynomial, box: FloatArray) -> bool:
    """Return False if f has one sign in the whole box (2, d), by its bounds on a few blocks."""
    walls = [np.linspace(start, end, SIGN_BLOCKS + 1) for start, end in box.T]
    low, high = bernstein.ranges(polynomial, [np.stack([line[:-1], line[1:]]) for line in walls])
    return bool(((low < 0.0) & (high >= 0.0)).any())


def _cells(polynomial: ImplicitPolynomial, lines: list[FloatArray], threads: int | None) -> Mesh:
    """Return the cells of f = 0 on the grid with `lines`, (N_axis,) each, by the faster of the two methods."""
    if np.prod([len(line) for line in lines]) > DENSE_NODES:
        return extract_pruned(polynomial, lines, threads)
    with np.errstate(over="ignore", invalid="ignore"):
        values = polynomial.on_grid(lines)
    if not np.isfinite(values).all():
        raise InvalidOptionsError("the polynomial overflows in this box; take smaller bounds", ("bounds",))
    return extract(values, lines)
