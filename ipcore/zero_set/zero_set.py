"""The zero set of a polynomial in a box: a mesh on f = 0, its number of components and its stray share."""

from dataclasses import dataclass

import numpy as np

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.components import count_components
from ipcore.zero_set.mesh import SEGMENT, Mesh, cell_vectors, chains, labels
from ipcore.zero_set.newton import polish, unit_normals
from ipcore.zero_set.refinement import extracted
from ipcore.zero_set.stray import stray_cells, stray_share


@dataclass(frozen=True, eq=False)
class ZeroSet:
    """Segments (2D) or triangles (3D) on f = 0, and what is known of the whole zero set in the box.

    Attributes
    ----------
    vertices
        (V, d), raw.
    cells
        (C, d), indices of vertices: segments with the inside (f < 0) on the left, or triangles that are
        counter-clockwise seen from outside.
    normals
        (V, d), ∇f/‖∇f‖ at the vertices; within a cap the outward normal of the wall; zero where ∇f vanishes.
    components
        The number of connected components of the whole zero set in the box, before any restriction and without caps;
        one that is thinner than the grid's cells in places counts once, though its cells may be in pieces.
    stray
        The share of the whole zero set's length or area that lies away from the data (see the rule in `stray`); None
        if no data were given or there is no zero set.
    resolution
        The grid points along the longest axis, asked for or chosen.
    thin
        The share of the zero set (near the data, if it is restricted to them) where the inside or the outside is
        thinner than four cells of the grid; 1 if only a finer grid finds any; None if there is no zero set.
    warning
        A sentence that says that the grid is too coarse; None if it is fine enough.

    """

    vertices: FloatArray
    cells: IntArray
    normals: FloatArray
    components: int
    stray: float | None
    resolution: int
    thin: float | None
    warning: str | None

    @property
    def dimension(self) -> int:
        """Return d, 2 or 3."""
        return int(self.vertices.shape[1])

    def polylines(self) -> list[FloatArray]:
        """Return the chains of segments, each (n, 2), raw, inside on the left; a closed one repeats its first vertex.

        Raises
        ------
        InvalidOptionsError
            If the zero set is a surface, which has no chains.

        """
        if self.cells.shape[1] != SEGMENT:
            raise InvalidOptionsError("only a zero set in 2D has polylines")
        return [self.vertices[chain] for chain in chains(self.cells)]

    def cell_normals(self) -> FloatArray:
        """Return the outward normals of the cells (C, d), each as long as its segment or as large as its triangle.

        So the norms of the rows add up to the length of a curve (raw units) or the area of a surface (raw units²).
        """
        return cell_vectors(self.vertices, self.cells)

    def vertex_components(self) -> IntArray:
        """Return the number of the connected component in which each vertex lies, (V,), from 0.

        Cells are connected if they share a vertex. A vertex of no cell is a component of its own.

        >>> two = ZeroSet(np.zeros((5, 2)), np.array([[0, 1], [1, 2], [3, 4]]), np.zeros((5, 2)), 2, None, 9, 0.0, None)
        >>> two.vertex_components().tolist()
        [0, 0, 0, 1, 1]
        """
        return labels(self.cells, len(self.vertices))

    def cells_near(self, data: FloatArray) -> BoolArray:
        """Return which cells are not stray, (C,), given the data (N, d), raw; the cells must be no caps.

        These are the cells that a zero set restricted to the data keeps, but for caps.
        """
        return ~stray_cells(self.vertices, self.cells, data)


def zero_set(  # noqa: PLR0913 - two are the box and its grid, three what is kept of the zero set
    polynomial: ImplicitPolynomial,
    bounds: FloatArray | None = None,
    resolution: int | None = None,
    *,
    data: FloatArray | None = None,
    restrict: bool = True,
    cap: bool = True,
    threads: int | None = None,
) -> ZeroSet:
    """Return the zero set f = 0 in a box.

    Parameters
    ----------
    polynomial
        f, negative inside.
    bounds
        (2, d), lower and upper corner of the box, raw; default: the polynomial's own bounds.
    resolution
        Grid points along the longest axis, at least 4; the other axes get as many as make the grid cells near-cubic.
        By default 256 in 2D and 96 in 3D, doubled until at most 15 % of the zero set is thinner than four grid cells
        (up to 8192 in 2D and 1536 in 3D, and not if there would be more than 600,000 cells).
    data
        (N, d), raw points, at least 2, against which `stray` is measured.
    restrict
        Leave out the stray cells (see the rule in `stray`), if data are given.
    cap
        Close the inside along the walls of the box where f = 0 leaves it. When restricting, a cap stays only if the
        zero set stays along its whole rim.
    threads
        How many threads work; by default OMP_NUM_THREADS if set, else all cores. They change nothing beyond rounding.

    Raises
    ------
    InvalidOptionsError
        If the box is empty or not finite, the resolution less than 4, or f overflows in the box.
    InvalidPointsError
        If `data` are not (N, d), finite, N ≥ 2.

    Examples
    --------
    The circle of radius 2 about the origin, length 4π = 12.566…:

    >>> from ipcore import Frame
    >>> frame = Frame(np.zeros(2), 1.0)
    >>> box = np.array([[-3.0, -3.0], [3.0, 3.0]])
    >>> circle = ImplicitPolynomial(2, np.array([-4.0, 0, 0, 1, 0, 1]), frame, box)
    >>> curve = zero_set(circle)
    >>> float(np.abs(np.linalg.norm(curve.vertices, axis=1) - 2.0).max()) < 1e-14
    True
    >>> ring, = curve.polylines()
    >>> round(float(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum()), 3)
    12.566

    """
    given = None if data is None else _checked(data, polynomial.dimension)
    found = extracted(polynomial, bounds, resolution, given if restrict else None, threads)
    mesh = polish(found.mesh, polynomial, found.box, found.spacing, threads)
    surface = ~mesh.cap
    stray, dropped = (None, None) if given is None else _stray(mesh, surface, given, threads)
    kept = _kept(mesh, dropped if restrict else None, cap=cap)
    part = mesh if kept.all() else mesh.keep(kept)
    return ZeroSet(
        part.vertices,
        part.cells,
        unit_normals(part, polynomial, found.box, threads),
        count_components(polynomial, mesh.vertices, mesh.cells[surface], found.spacing, found.box),
        stray,
        found.resolution,
        found.thin,
        found.warning(asked=resolution is not None),
    )


def _checked(data: FloatArray, d: int) -> FloatArray:
    """Return data as doubles (N, d), or raise."""
    given = np.asarray(data, dtype=np.float64)
    if given.shape[1:] != (d,) or len(given) <= 1 or not np.isfinite(given).all():
        raise InvalidPointsError(f"data must be at least 2 finite points, shape (N, {d})", ("data",))
    return given


def _stray(mesh: Mesh, surface: BoolArray, data: FloatArray, threads: int | None) -> tuple[float | None, BoolArray]:
    """Return the stray share, and which cells are stray, (C,).

    `surface` (C,) marks the cells that are no caps; `data` (N, d) are raw.
    """
    cells = mesh.cells[surface]
    stray = stray_cells(mesh.vertices, cells, data, threads)
    dropped = np.zeros(len(surface), dtype=bool)
    dropped[surface] = stray
    return stray_share(mesh.vertices, cells, stray), dropped


def _kept(mesh: Mesh, dropped: BoolArray | None, *, cap: bool) -> BoolArray:
    """Return which cells to keep, (C,): no `dropped` (C,) ones; with `cap`, the caps too, if they close a surface."""
    surface = ~mesh.cap
    if dropped is None:
        return np.full_like(surface, cap and bool(surface.any())) | surface
    kept = surface & ~dropped
    return kept | mesh.caps_around(kept) if cap else kept
