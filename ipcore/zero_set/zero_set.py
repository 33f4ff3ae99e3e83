"""The zero set of a polynomial in a box: a mesh on f = 0, its number of components and its stray share."""

from dataclasses import dataclass

import numpy as np

from ipcore._threads import by_rows
from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.extraction import extract, extract_pruned
from ipcore.zero_set.grid import grid_lines
from ipcore.zero_set.mesh import SEGMENT, Mesh, cell_middles, cell_vectors, chains, labels
from ipcore.zero_set.newton import polish, unit_normals
from ipcore.zero_set.support import radii_exceeded

DENSE_NODES = 1 << 21  # up to so many nodes, to evaluate all of them takes no longer than to find those that matter


@dataclass(frozen=True, eq=False)
class ZeroSet:
    """Segments (2D) or triangles (3D) on f = 0, and two figures of the whole zero set in the box.

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
        The number of connected components of the whole zero set in the box, before any restriction and without caps.
    stray
        The share of the whole zero set's length or area that is beyond the support radius of the data (see `support`);
        1 if there is no zero set at all, None if no data were given.

    """

    vertices: FloatArray
    cells: IntArray
    normals: FloatArray
    components: int
    stray: float | None

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

        >>> two = ZeroSet(np.zeros((5, 2)), np.array([[0, 1], [1, 2], [3, 4]]), np.zeros((5, 2)), 2, None)
        >>> two.vertex_components().tolist()
        [0, 0, 0, 1, 1]
        """
        return labels(self.cells, len(self.vertices))

    def cells_near(self, data: FloatArray) -> BoolArray:
        """Return which cells have their middle within the support or the gap radius of the data (N, d), raw: (C,).

        These are the cells that a zero set restricted to the data keeps, but for caps.
        """
        return radii_exceeded(cell_middles(self.vertices, self.cells), data) <= 1


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
        Default 256 in 2D, 96 in 3D.
    data
        (N, d), raw points, at least 2, against which `stray` is measured.
    restrict
        Keep only the cells whose middle is within the support radius or the gap radius of the data, if these are given.
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
    axes = grid_lines(polynomial, bounds, resolution)
    box = np.array([line[[0, -1]] for line in axes]).T
    spacing = max(line[1] - line[0] for line in axes)
    mesh = polish(_extracted(polynomial, axes, threads), polynomial, box, spacing, threads)
    surface = ~mesh.cap
    given = None if data is None else np.asarray(data, dtype=np.float64)
    stray, dropped = (None, None) if given is None else _unsupported(mesh, surface, given, threads)
    kept = _kept(mesh, dropped if restrict else None, cap=cap)
    part = mesh if kept.all() else mesh.keep(kept)
    return ZeroSet(
        part.vertices,
        part.cells,
        unit_normals(part, polynomial, box, threads),
        _components(mesh.cells[surface], len(mesh.vertices)),
        stray,
    )


def _extracted(polynomial: ImplicitPolynomial, axes: list[FloatArray], threads: int | None) -> Mesh:
    """Return the cells of f = 0 on the grid with lines `axes`, (N_axis,) each, by the faster of the two methods."""
    if np.prod([len(line) for line in axes]) > DENSE_NODES:
        return extract_pruned(polynomial, axes, threads)
    with np.errstate(over="ignore", invalid="ignore"):
        values = polynomial.on_grid(axes)
    if not np.isfinite(values).all():
        raise InvalidOptionsError("the polynomial overflows in this box; take smaller bounds", ("bounds",))
    return extract(values, axes)


def _unsupported(mesh: Mesh, surface: BoolArray, data: FloatArray, threads: int | None) -> tuple[float, BoolArray]:
    """Return the stray share, and which cells a restricted zero set leaves out, (C,).

    `surface` (C,) marks the cells that are no caps; `data` (N, d) are raw.
    """
    d = mesh.vertices.shape[1]
    if data.shape[1:] != (d,) or len(data) <= 1 or not np.isfinite(data).all():
        raise InvalidPointsError(f"data must be at least 2 finite points, shape (N, {d})", ("data",))
    middle = by_rows(lambda part: cell_middles(mesh.vertices, mesh.cells[part]), len(mesh.cells), threads)
    exceeded = radii_exceeded(middle, data, threads)
    return _share(mesh, surface, exceeded > 0), exceeded > 1


def _share(mesh: Mesh, surface: BoolArray, far: BoolArray) -> float:
    """Return the share of the surface cells' length or area that is `far`; both mark cells, (C,). 1 without surface."""
    size = np.linalg.norm(cell_vectors(mesh.vertices, mesh.cells), axis=1)
    whole = float(size[surface].sum())
    return float(size[surface & far].sum()) / whole if whole > 0.0 else 1.0


def _components(cells: IntArray, vertices: int) -> int:
    """Return the number of connected components of cells (C, d), given V, `vertices`."""
    return len(np.unique(labels(cells, vertices)[cells]))


def _kept(mesh: Mesh, dropped: BoolArray | None, *, cap: bool) -> BoolArray:
    """Return which cells to keep, (C,): no `dropped` (C,) ones; with `cap`, the caps too, if they close a surface."""
    surface = ~mesh.cap
    if dropped is None:
        return np.full_like(surface, cap and bool(surface.any())) | surface
    kept = surface & ~dropped
    return kept | mesh.caps_around(kept) if cap else kept
