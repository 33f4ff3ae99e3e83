"""The zero set of a polynomial in a box: its cells, polished onto it, and the evidence that it is quiet."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.errors import InvalidOptionsError, InvalidPointsError
from ipcore.extraction import extract
from ipcore.frame import Frame
from ipcore.mesh import SEGMENT, Mesh, cell_vectors, chains, labels
from ipcore.polishing import polish, unit_normals
from ipcore.polynomial import ImplicitPolynomial

# Grid points along the longest axis. At degree 12 these take 0.01 s and 0.2 s, and leave the length of a bumpy circle
# 1e-5 and the area of a bumpy sphere 4e-4 short.
RESOLUTION = {2: 256, 3: 96}
# What is near the data, in mean radii and in point spacings, when stray parts are measured: chosen over 37 shapes so
# that neither sparse sampling nor noise makes a good fit's own surface stray.
NEAR_RADII = {2: 0.10, 3: 0.12}
NEAR_SPACINGS = 2.5
# What is left in a restricted zero set reaches farther where points lie at random, so that it has no holes at their
# gaps: 1.25 times the 99th percentile of the distance to the 6th nearest other point. Of N random points on a surface
# of density ρ that is 2.5/√ρ, and a gap of that radius has the chance e⁻²⁰ N; on a square grid it is 1.8 spacings.
GAP_NEIGHBOUR = 6
GAP_QUANTILE = 0.99
GAP_FACTOR = 1.25
FEWEST = 4  # grid points per axis


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
        How many connected components the whole zero set has in the box, before any restriction and without caps.
    stray
        The share of its length or area that is farther than `near` from every data point; 1 if there is no zero set
        at all, None if no data were given.

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


def zero_set(  # noqa: PLR0913 - two say where, one how fine, three what to do with it
    polynomial: ImplicitPolynomial,
    bounds: FloatArray | None = None,
    resolution: int | None = None,
    *,
    data: FloatArray | None = None,
    restrict: bool = True,
    cap: bool = True,
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
        Keep only the cells whose middle is `near` the data, if these are given.
    cap
        Close the inside along the walls of the box where f = 0 leaves it. When restricting, a cap stays only if the
        zero set stays along its whole rim.

    Raises
    ------
    InvalidOptionsError
        If the box is empty or not finite, the resolution less than 4, or f overflows in the box.
    InvalidPointsError
        If `data` are not (N, d), finite, N ≥ 2.

    Examples
    --------
    The circle of radius 2 about the origin, length 4π = 12.566…:

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
    axes = _grid_lines(polynomial, bounds, resolution)
    with np.errstate(over="ignore", invalid="ignore"):
        values = polynomial.on_grid(axes)
    if not np.isfinite(values).all():
        raise InvalidOptionsError("the polynomial overflows in this box; take smaller bounds", ("bounds",))
    box = np.array([line[[0, -1]] for line in axes]).T
    spacing = max(line[1] - line[0] for line in axes)
    mesh = polish(extract(values, axes), polynomial, box, spacing)
    surface = ~mesh.cap
    stray, dropped = (None, None) if data is None else _away(mesh, surface, np.asarray(data, dtype=np.float64))
    part = mesh.keep(_kept(mesh, dropped if restrict else None, cap=cap))
    return ZeroSet(
        part.vertices,
        part.cells,
        unit_normals(part, polynomial, box),
        _components(mesh.cells[surface], len(mesh.vertices)),
        stray,
    )


def near(data: FloatArray, scale: float) -> float:
    """Return the distance, raw, within which data (N, d) support a zero set.

    max(0.10 · scale in 2D or 0.12 · scale in 3D, 2.5 · median distance to the nearest other point); `scale` is the
    mean radius of the data, raw.

    >>> near(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), scale=10.0)
    2.5
    """
    distances, _ = cKDTree(data).query(data, k=2)
    return max(NEAR_RADII[data.shape[1]] * scale, NEAR_SPACINGS * float(np.median(np.asarray(distances)[:, 1])))


def reach(data: FloatArray) -> float:
    """Return the distance, raw, across which data (N, d) are taken to be one: the gaps of a random sample.

    >>> turn = 2 * np.pi * np.arange(100) / 100        # the 6th nearest is 3 steps along
    >>> round(reach(100 / (2 * np.pi) * np.column_stack([np.cos(turn), np.sin(turn)])), 2)
    3.74
    """
    k = min(GAP_NEIGHBOUR, len(data) - 1)
    distances, _ = cKDTree(data).query(data, k=k + 1, workers=-1)
    return GAP_FACTOR * float(np.quantile(np.asarray(distances)[:, k], GAP_QUANTILE))


def _grid_lines(polynomial: ImplicitPolynomial, bounds: FloatArray | None, resolution: int | None) -> list[FloatArray]:
    """Return the raw grid lines of each axis, as evenly spaced as whole numbers of them allow."""
    d = polynomial.dimension
    box = polynomial.bounds if bounds is None else np.asarray(bounds, dtype=np.float64)
    count = RESOLUTION[d] if resolution is None else resolution
    if box.shape != (2, d) or not np.isfinite(box).all() or not np.all(box[0] < box[1]):
        raise InvalidOptionsError(f"bounds must be a lower and an upper corner of {d} coordinates", ("bounds",))
    if count < FEWEST:
        raise InvalidOptionsError(f"resolution must be at least {FEWEST}, not {count}", ("resolution",))
    sides = box[1] - box[0]
    counts = np.maximum(FEWEST, 1 + np.rint((count - 1) * sides / sides.max())).astype(int)
    return [np.linspace(low, high, n) for (low, high), n in zip(box.T, counts, strict=True)]


def _away(mesh: Mesh, surface: BoolArray, data: FloatArray) -> tuple[float, BoolArray]:
    """Return the stray share, and which cells (C,) a restricted zero set leaves out."""
    d = mesh.vertices.shape[1]
    if data.shape[1:] != (d,) or len(data) <= 1 or not np.isfinite(data).all():
        raise InvalidPointsError(f"data must be at least 2 finite points, shape (N, {d})", ("data",))
    close, scale = reach(data), Frame.of(data).scale
    supported = near(data, scale)
    middle = mesh.vertices[mesh.cells].mean(axis=1)
    distance, _ = cKDTree(data).query(middle, distance_upper_bound=max(supported, close), workers=-1)
    return _share(mesh, surface, np.asarray(distance > supported)), np.isinf(distance)


def _share(mesh: Mesh, surface: BoolArray, far: BoolArray) -> float:
    """Return the share of the length or area of the surface cells that is far."""
    size = np.linalg.norm(cell_vectors(mesh.vertices, mesh.cells), axis=1)
    whole = float(size[surface].sum())
    return float(size[surface & far].sum()) / whole if whole > 0.0 else 1.0


def _components(cells: IntArray, vertices: int) -> int:
    return len(np.unique(labels(cells, vertices)[cells]))


def _kept(mesh: Mesh, dropped: BoolArray | None, *, cap: bool) -> BoolArray:
    """Return the cells (C,) to keep: without the dropped ones, and with caps, if there is a surface to close."""
    surface = ~mesh.cap
    if dropped is None:
        return np.full_like(surface, cap and bool(surface.any())) | surface
    kept = surface & ~dropped
    return kept | mesh.caps_round(kept) if cap else kept
