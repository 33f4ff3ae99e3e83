"""The picture of a fit in 3D: its zero set as a shaded surface, by the painter's algorithm, and the data beside it."""

from dataclasses import replace

import numpy as np

import ipcore
from service.formats.picture.facets import TENTHS, Facets, is_closed
from service.formats.picture.plane import HEIGHT, WIDTH, LegendEntries, Placing, dots, supported
from service.formats.picture.shading import RAMPS, light, styles, triangles
from service.formats.picture.view import View

# Triangles to paint at most: at 49 bytes each they make 590 kB. Of these resolutions, in grid points along the longest
# axis, the finest is taken that needs no more.
MOST_TRIANGLES = 12_000
RESOLUTIONS = (64, 56, 48, 42, 36, 30, 24)
FINEST_PAINTED = 512  # grid points, for zero sets that are too thin for these: a needle 100 : 1 is then seen
MARGIN_PIXELS = 8.0  # px
INSET = 96.0  # px, the side of the square in a corner in which the data are drawn


def surface(polynomial: ipcore.ImplicitPolynomial, points: ipcore.FloatArray, view: View) -> tuple[str, LegendEntries]:
    """Draw the zero set near the data (N, 3), shaded, and the data beside it.

    Return the drawing, with its upper left corner at the origin, and the entries of its legend.
    """
    mesh, axes = _extract(polynomial, points), view.axes()
    seen, cloud = mesh.vertices @ axes.T, points @ axes.T
    place = _placing(seen if len(seen) else cloud, WIDTH, HEIGHT)
    facets = Facets.of(mesh.cells, seen, place)
    drawing = [
        f"<style>{styles()}</style>",
        f'<g id="surface" transform="scale({1.0 / TENTHS:g})" stroke-width="5" stroke-linejoin="round">',
        *triangles(facets, light(mesh.normals @ axes.T, facets)),
        "</g>",
        _inset(cloud, place(seen[:, :2])),
    ]
    stray = f" (stray {mesh.stray:.1%}, not drawn)" if mesh.stray else ""
    return "\n".join(drawing), [
        (dots(np.zeros((1, 2)), 4.2, 0.6), f"{len(points):,} points"),
        (_ball(), f"f = 0 near the data{stray}"),
    ]


def _extract(polynomial: ipcore.ImplicitPolynomial, points: ipcore.FloatArray) -> ipcore.ZeroSet:
    """Return the part of the zero set that the data (N, 3) describe, at the finest resolution that can be painted.

    Where the finest of `RESOLUTIONS` is too coarse for a thin zero set, it is doubled as long as that can be painted.
    """
    meshes = (_described(polynomial, points, resolution) for resolution in RESOLUTIONS)
    mesh = next((one for one in meshes if _can_be_painted(one)), None)
    if mesh is None:
        return _described(polynomial, points, RESOLUTIONS[-1])
    while mesh.warning is not None and 2 * mesh.resolution <= FINEST_PAINTED:
        finer = _described(polynomial, points, 2 * mesh.resolution)
        if not _can_be_painted(finer):
            break
        mesh = finer
    return mesh


def _can_be_painted(mesh: ipcore.ZeroSet) -> bool:
    """Return whether a mesh has few enough triangles; of a closed one, half of them are seen."""
    return len(mesh.cells) <= MOST_TRIANGLES * (2 if is_closed(mesh.cells) else 1)


def _described(polynomial: ipcore.ImplicitPolynomial, points: ipcore.FloatArray, resolution: int) -> ipcore.ZeroSet:
    """Return the part of the zero set that the data (N, 3) describe, without unused vertices."""
    whole = ipcore.zero_set(polynomial, resolution=resolution, data=points, restrict=False, cap=False)
    cells = whole.cells[supported(whole, points)]
    used, renumbered = np.unique(cells, return_inverse=True)
    return replace(
        whole, vertices=whole.vertices[used], cells=renumbered.reshape(cells.shape), normals=whole.normals[used]
    )


def _placing(seen: ipcore.FloatArray, width: float, height: float) -> Placing:
    """Return the map that places points (N, 3), given to the right, up and towards the eye, within the picture."""
    corners = np.stack([seen.min(axis=0), seen.max(axis=0)])[:, :2]
    inner = Placing.into(width - 2.0 * MARGIN_PIXELS, height - 2.0 * MARGIN_PIXELS, corners)
    return replace(inner, middle=np.array([width, height]) / 2.0)


def _inset(cloud: ipcore.FloatArray, shape: ipcore.FloatArray) -> str:
    """Draw the data (N, 3) small, from the same direction, in the corner with the fewest of the vertices (V, 2), px."""
    ends = [(0.0, 0.0), (WIDTH - INSET, 0.0), (0.0, HEIGHT - INSET), (WIDTH - INSET, HEIGHT - INSET)]
    corner = min(ends, key=lambda end: int(((shape >= end) & (shape <= np.add(end, INSET))).all(axis=1).sum()))
    at = _placing(cloud, INSET, INSET)(cloud[:, :2]) + corner
    return dots(at, 1.5, 0.5)


def _ball() -> str:
    (dark, light) = (RAMPS["outside"][k] for k in (1, 2))
    return f'<circle r="6" fill="rgb{light}" stroke="rgb{dark}"/>'
