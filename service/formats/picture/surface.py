"""A fit in 3D as a shaded surface: every triangle that faces the eye, the farthest first (the painter's algorithm)."""

from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np

import ipcore
from service.formats.picture.plane import HEIGHT, WIDTH, LegendEntries, Placing, dots, supported

# Triangles to paint at most: at 49 bytes each they make 590 kB. The finest of these resolutions is taken that needs no
# more, in grid points along the longest axis.
MOST_TRIANGLES = 12_000
RESOLUTIONS = (64, 56, 48, 42, 36, 30, 24)
TENTHS = 10.0  # triangles are drawn in whole tenths of a px, which saves their decimal points
MARGIN = 8.0  # px
INSET = 96.0  # px, the side of the square in a corner where the data are shown
# Lights: direction (right, up, towards the eye) and strength. One from above on the left, and one from the right to
# lift its shadows; what faces away from both has only the ambient light. Chosen by eye on the Stanford bunny.
LIGHTS = (((-0.5, 0.75, 0.6), 0.74), ((0.85, 0.1, 0.5), 0.24))
AMBIENT = 0.12
SHADES = 64
# Colours of light 0 … 1, for the outside of the surface and for its inside, which shows where it is open.
STOPS = (0.0, 0.4, 0.75, 1.0)
RAMPS = {
    "outside": ((18, 38, 66), (48, 104, 166), (139, 186, 228), (244, 250, 255)),
    "inside": ((64, 58, 52), (140, 132, 124), (199, 192, 185), (246, 243, 240)),
}


@dataclass(frozen=True)
class View:
    """From where a surface is seen, orthographically.

    Attributes
    ----------
    up
        The axis that points up: y, as in glTF and for most scanned models, or z, as in mathematics and CAD.
    azimuth
        Degrees to the right of the front, which is +z when y is up and −y when z is up.
    elevation
        Degrees above the horizon.

    """

    up: Literal["y", "z"] = "y"
    azimuth: float = 30.0
    elevation: float = 20.0

    def axes(self) -> ipcore.FloatArray:
        """Return the unit vectors to the right, up and towards the eye, the rows of a rotation (3, 3).

        >>> View("z", azimuth=0.0, elevation=0.0).axes().round().astype(int).tolist()
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
        """
        x, y, z = np.eye(3)
        up, front = (y, z) if self.up == "y" else (z, -y)
        a, e = np.radians([self.azimuth, self.elevation])
        right = np.cos(a) * x - np.sin(a) * front
        towards = np.cos(e) * (np.sin(a) * x + np.cos(a) * front) + np.sin(e) * up
        return np.stack([right, np.cross(towards, right), towards])


@dataclass(frozen=True, eq=False)
class Facets:
    """The triangles that are seen, in the order in which they are painted.

    Attributes
    ----------
    corners
        (K, 3, 2), in whole tenths of a px.
    cells
        (K, 3), the mesh's vertices there.
    outside
        (K,), whether the eye sees the outer face.
    depth
        (K,), how near the middle is to the eye, raw; never falls.

    """

    corners: ipcore.IntArray
    cells: ipcore.IntArray
    outside: ipcore.BoolArray
    depth: ipcore.FloatArray

    @classmethod
    def of(cls, cells: ipcore.IntArray, seen: ipcore.FloatArray, place: Placing) -> Self:
        """Return the triangles (C, 3) of vertices (V, 3), right, up and towards the eye, as they are painted.

        Those that turn their inner face are left out if the surface is closed, which hides them.
        """
        corners = np.rint(TENTHS * place(seen[:, :2])).astype(np.intp)[cells]
        (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
        turn = bx * ay - ax * by  # counter-clockwise where y is up, clockwise in a picture
        depth = seen[cells, 2].mean(axis=1)
        order = np.argsort(depth, kind="stable")
        order = order[turn[order] > 0 if _closed(cells) else turn[order] != 0]
        return cls(corners[order], cells[order], turn[order] > 0, depth[order])


def surface(polynomial: ipcore.ImplicitPolynomial, points: ipcore.FloatArray, view: View) -> tuple[str, LegendEntries]:
    """Draw the zero set near the data, shaded, and the data beside it.

    Returns the drawing, from the origin to the right and down, and the entries of its legend.
    """
    mesh, axes = _extract(polynomial, points), view.axes()
    seen, cloud = mesh.vertices @ axes.T, points @ axes.T
    place = _placing(seen if len(seen) else cloud, WIDTH, HEIGHT)
    facets = Facets.of(mesh.cells, seen, place)
    drawing = [
        f"<style>{_styles()}</style>",
        f'<g id="surface" transform="scale({1.0 / TENTHS:g})" stroke-width="5" stroke-linejoin="round">',
        *_triangles(facets, _light(mesh.normals @ axes.T, facets)),
        "</g>",
        _inset(cloud, place(seen[:, :2])),
    ]
    stray = f" (stray {mesh.stray:.1%}, not drawn)" if mesh.stray else ""
    return "\n".join(drawing), [
        (dots(np.zeros((1, 2)), 4.2, 0.6), f"{len(points):,} points"),
        (_ball(), f"f = 0 near the data{stray}"),
    ]


def _extract(polynomial: ipcore.ImplicitPolynomial, points: ipcore.FloatArray) -> ipcore.ZeroSet:
    """Return the zero set that the data support, as fine as can be painted."""
    meshes = (_supported(polynomial, points, resolution) for resolution in RESOLUTIONS)
    for mesh in meshes:
        if len(mesh.cells) <= MOST_TRIANGLES * (2 if _closed(mesh.cells) else 1):
            break
    return mesh


def _supported(polynomial: ipcore.ImplicitPolynomial, points: ipcore.FloatArray, resolution: int) -> ipcore.ZeroSet:
    whole = ipcore.zero_set(polynomial, resolution=resolution, data=points, restrict=False, cap=False)
    cells = whole.cells[supported(whole, points)]
    used, renumbered = np.unique(cells, return_inverse=True)
    return replace(
        whole, vertices=whole.vertices[used], cells=renumbered.reshape(cells.shape), normals=whole.normals[used]
    )


def _placing(seen: ipcore.FloatArray, width: float, height: float) -> Placing:
    """Return how to place points (N, 3), right, up and towards the eye, so that all are in the picture."""
    corners = np.stack([seen.min(axis=0), seen.max(axis=0)])[:, :2]
    inner = Placing.into(width - 2.0 * MARGIN, height - 2.0 * MARGIN, corners)
    return replace(inner, middle=np.array([width, height]) / 2.0)


def _closed(cells: ipcore.IntArray) -> bool:
    """Return whether every edge of the triangles belongs to two of them."""
    edges = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


def _light(normals: ipcore.FloatArray, facets: Facets) -> ipcore.FloatArray:
    """Return how bright the facets are (K,), 0 … 1, by Lambert's law: ambient + Σ strength · max(0, n · l)."""
    n = normals[facets.cells].sum(axis=1) * np.where(facets.outside, 1.0, -1.0)[:, None]
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), np.finfo(float).tiny)
    light = np.full(len(n), AMBIENT)
    for direction, strength in LIGHTS:
        light += strength * np.maximum(n @ np.array(direction) / np.linalg.norm(direction), 0.0)
    return np.asarray(np.clip(light, 0.0, 1.0))


def _triangles(facets: Facets, light: ipcore.FloatArray) -> list[str]:
    """Return a path for each facet: its first corner, and the steps to the others."""
    shades = np.rint((SHADES - 1) * light).astype(int).tolist()
    steps = np.diff(facets.corners, axis=1)
    rows = np.concatenate([facets.corners[:, 0], steps.reshape(-1, 4)], axis=1).tolist()
    return [
        f'<path class="{"o" if outside else "i"}{shade}" d="M{x} {y}l{ax} {ay} {bx} {by}z"/>'
        for (x, y, ax, ay, bx, by), outside, shade in zip(rows, facets.outside.tolist(), shades, strict=True)
    ]


def _styles() -> str:
    """Return a class for every shade. They are the same in all pictures, so several may share a page.

    The stroke, half a px wide, covers the seam that smoothing leaves between neighbours.
    """
    light = np.linspace(0.0, 1.0, SHADES)
    return "".join(
        ".{0}{1}{{fill:#{2:02x}{3:02x}{4:02x};stroke:#{2:02x}{3:02x}{4:02x}}}".format(side[0], shade, *colour)
        for side, ramp in RAMPS.items()
        for shade, colour in enumerate(
            np.rint([np.interp(light, STOPS, channel) for channel in zip(*ramp, strict=True)]).astype(int).T.tolist()
        )
    )


def _inset(cloud: ipcore.FloatArray, shape: ipcore.FloatArray) -> str:
    """Draw the data from the same side, small, in the corner where the least of the shape (V, 2), px, is."""
    ends = [(0.0, 0.0), (WIDTH - INSET, 0.0), (0.0, HEIGHT - INSET), (WIDTH - INSET, HEIGHT - INSET)]
    corner = min(ends, key=lambda end: int(((shape >= end) & (shape <= np.add(end, INSET))).all(axis=1).sum()))
    at = _placing(cloud, INSET, INSET)(cloud[:, :2]) + corner
    return dots(at, 1.5, 0.5)


def _ball() -> str:
    (dark, light) = (RAMPS["outside"][k] for k in (1, 2))
    return f'<circle r="6" fill="rgb{light}" stroke="rgb{dark}"/>'
