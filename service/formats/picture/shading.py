"""The shades of painted triangles: Lambert's law, a few lights, and a colour for each shade."""

import numpy as np

import ipcore
from service.formats.picture.facets import Facets

# Lights: direction (right, up, towards the eye) and strength. One from above on the left, and one from the right that
# brightens its shadows; facets turned away from both have only the ambient light. Chosen by eye on the Stanford bunny.
LIGHTS = (((-0.5, 0.75, 0.6), 0.74), ((0.85, 0.1, 0.5), 0.24))
AMBIENT = 0.12
SHADES = 64
# Colours for light 0 … 1, at these stops: of the outer side of the surface, and of the inner side where it is open.
STOPS = (0.0, 0.4, 0.75, 1.0)
RAMPS = {
    "outside": ((18, 38, 66), (48, 104, 166), (139, 186, 228), (244, 250, 255)),
    "inside": ((64, 58, 52), (140, 132, 124), (199, 192, 185), (246, 243, 240)),
}


def light(normals: ipcore.FloatArray, facets: Facets) -> ipcore.FloatArray:
    """Return the brightness (K,) of facets, 0 … 1, by Lambert's law: ambient + Σ strength · max(0, n · l).

    `normals` (V, 3) are those of the vertices, in the coordinates right, up and towards the eye.
    """
    n = normals[facets.cells].sum(axis=1) * np.where(facets.outside, 1.0, -1.0)[:, None]
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), np.finfo(float).tiny)
    total = np.full(len(n), AMBIENT)
    for direction, strength in LIGHTS:
        total += strength * np.maximum(n @ np.array(direction) / np.linalg.norm(direction), 0.0)
    return np.asarray(np.clip(total, 0.0, 1.0))


def triangles(facets: Facets, light: ipcore.FloatArray) -> list[str]:
    """Return the SVG path of each facet, with its first corner and the steps to the others, from its light (K,)."""
    shades = np.rint((SHADES - 1) * light).astype(int).tolist()
    steps = np.diff(facets.corners, axis=1)
    rows = np.concatenate([facets.corners[:, 0], steps.reshape(-1, 4)], axis=1).tolist()
    return [
        f'<path class="{"o" if outside else "i"}{shade}" d="M{x} {y}l{ax} {ay} {bx} {by}z"/>'
        for (x, y, ax, ay, bx, by), outside, shade in zip(rows, facets.outside.tolist(), shades, strict=True)
    ]


def styles() -> str:
    """Return the CSS class of every shade. They are the same in all pictures, so several may stand on one page.

    The stroke, half a px wide, covers the seams that anti-aliasing leaves between neighbours.
    """
    light = np.linspace(0.0, 1.0, SHADES)
    return "".join(
        ".{0}{1}{{fill:#{2:02x}{3:02x}{4:02x};stroke:#{2:02x}{3:02x}{4:02x}}}".format(side[0], shade, *colour)
        for side, ramp in RAMPS.items()
        for shade, colour in enumerate(
            np.rint([np.interp(light, STOPS, channel) for channel in zip(*ramp, strict=True)]).astype(int).T.tolist()
        )
    )
